"""Rows that are averaged over windows: what noise hides of a step shows over many.

A state's change over a window is the sum of its steps' changes, and so are the terms that make it, while the noise of
the measured state enters at the window's ends alone: the weak form of the regression, with a constant test function (D.
Messenger, D. Bortz, "Weak SINDy", Multiscale Model. Simul. 19, 2021).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Transitions
from sym2real.regression.monomials import Monomials
from sym2real.trajectory import Array

# Rows (of 20 to 50 ms) over which the changes of a measured state are averaged: a rate follows its command within two,
# a velocity shows its acceleration beside the noise after some ten.
MEASURED = (1, 2, 5, 10, 20, 40)
# So many windows and more are worth a search.
FEWEST = 20
BLOCK = 20  # rows that validate together
OVERLAP = 4  # windows that share a row

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of consecutive rows, each a quarter of its length behind the one before.

    Args:
        starts: first row of each ``# (windows,)``.
        rows: of each.
    """

    starts: NDArray[np.int64]
    rows: int

    @classmethod
    def of(cls, transitions: Transitions, rows: int) -> Windows:
        """All that lie in one trajectory."""
        first = np.flatnonzero(transitions.step % max(1, rows // OVERLAP) == 0)
        first = first[first + rows <= len(transitions)]
        last = first + rows - 1
        whole = (transitions.trajectory[last] == transitions.trajectory[first]) & (
            transitions.step[last] == transitions.step[first] + rows - 1
        )
        return cls(first[whole], rows)

    def averaged(self, rows: Array) -> Array:
        """Means over the windows ``# (rows, …) -> (windows, …)``."""
        if self.rows == 1:
            return rows[self.starts]
        sums = np.concatenate([np.zeros((1, *rows.shape[1:])), np.cumsum(rows, axis=0)])
        means: Array = (sums[self.starts + self.rows] - sums[self.starts]) / self.rows
        return means

    def validating(self, transitions: Transitions, seed: int) -> Mask:
        """Those in every other block of 20 rows, or of four windows ``# (windows,)``; ``seed`` shifts by half a block.

        Neighbouring rows are nearly alike, so whole blocks are held back. A table shorter than two blocks is split
        window by window.
        """
        size = max(BLOCK, 4 * self.rows)
        block = (transitions.step[self.starts] + seed * (size // 2)) // size + transitions.trajectory[self.starts]
        if len(np.unique(block % 2)) < 2:
            block = np.arange(len(self.starts))
        held: Mask = block % 2 == 1
        return held


@dataclass(frozen=True, eq=False)
class Values:
    """Values of variables, and the windows over which products of them are averaged.

    Args:
        rows: scaled values ``# (rows, variables)``.
        windows: of the rows.
    """

    rows: Array
    windows: Windows

    def of(self, terms: Monomials) -> Array:
        """Averages of the products ``# (windows, terms)``."""
        return self.windows.averaged(terms.evaluate(self.rows))
