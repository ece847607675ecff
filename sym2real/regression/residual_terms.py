"""Short sums of products for what a model leaves of each state column, from noisy rows.

What is left is averaged over windows of consecutive rows, and so is every candidate: the noise of a measured state
enters one row with one sign and the next with the other, and cancels, while what a model lacks adds up. (Prefiltering:
L. Ljung, System Identification, 2nd ed., section 14.4.) A column gets the fewest terms whose error on blocks of time
that taught nothing is within a standard error of the least, and often that is none (one standard error rule: T. Hastie,
R. Tibshirani, J. Friedman, The Elements of Statistical Learning, 2nd ed., section 7.10).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import sympy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sym2real.dataset import Transitions
from sym2real.errors import ModelError
from sym2real.regression.features import Variables
from sym2real.regression.monomials import Monomials
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.refit import refit
from sym2real.regression.search import beam_search
from sym2real.regression.windows import Windows
from sym2real.trajectory import Array

BLOCK = 20  # rows that validate, or teach, together
FEWEST = 2  # blocks
FOLDS = 5
# Of a state column's own change in a step: less than that is left alone, so that rounding gets no terms.
SMALL = 1e-3
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class ResidualSettings:
    """How terms are searched.

    Args:
        degree: of the candidates.
        terms: most in a column.
        window: rows that are averaged; 1 takes each by itself.
        width, branch: of the beam search.
        seed: which blocks validate which.
    """

    degree: int = 3
    terms: int = 5
    window: int = 20
    width: int = 4
    branch: int = 4
    seed: int = 0


def residual_terms(
    transitions: Transitions, left: Array, settings: ResidualSettings, angles: Sequence[str] = ()
) -> dict[str, sympy.Expr]:
    """State column → sum of products that predicts what is left of it; columns without are missing.

    Args:
        transitions: states and actions that the terms are made of.
        left: of the next state ``# (rows, n)``.
        settings: of the search.
        angles: columns in rad whose sine and cosine may stand in terms.

    Raises:
        ModelError: for fewer than two blocks of consecutive rows.
    """
    with threadpool_limits(limits=1, user_api="blas"):  # small matrices: threads cost more than they gain
        search = _Search(transitions, settings, Variables.of(transitions.layouts, angles))
        change = transitions.next_state - transitions.state
        found = {}
        for position, column in enumerate(transitions.layouts.state):
            target = left[:, position]
            if np.sqrt(np.mean(target**2)) > SMALL * np.sqrt(np.mean(change[:, position] ** 2)):
                polynomial = search.polynomial(column, target)
                if len(polynomial):
                    found[column] = polynomial.increment(search.variables)
        return found


class _Search:
    """Candidates of one log, averaged over windows, for the targets of all columns."""

    def __init__(self, transitions: Transitions, settings: ResidualSettings, variables: Variables) -> None:
        self.settings, self.variables = settings, variables
        starts, block = _windows(transitions, settings.window)
        self.windows = Windows(starts, settings.window)
        blocks = len(np.unique(block))
        if blocks < FEWEST:
            raise ModelError(
                f"terms of a residual need at least {FEWEST * _size(settings.window)} consecutive transitions, "
                f"found {len(transitions)}"
            )
        self.fold = (block + settings.seed) % min(FOLDS, blocks)
        self.values = variables.values_of(transitions)
        scale = np.sqrt(np.mean(self.values**2, axis=0))
        self.scale = np.where(scale > 0, scale, 1.0)
        self.candidates = variables.products(settings.degree)
        self._pools: dict[bytes, tuple[Monomials, Array, Array]] = {}

    def _pool(self, sign: Rows) -> tuple[Monomials, Array, Array]:
        """Candidates of a sign pattern, their averaged values and the norms of these."""
        key = sign.tobytes()
        if key not in self._pools:
            terms = self.candidates.where((self.variables.signs(self.candidates.powers) == sign).all(axis=1))
            columns = self.windows.averaged(terms.evaluate(self.values / self.scale))
            norms = np.linalg.norm(columns, axis=0)
            alive = norms > 1e-9 * norms.max(initial=0.0)
            self._pools[key] = terms.where(alive), columns[:, alive] / norms[alive], norms[alive]
        return self._pools[key]

    def polynomial(self, column: str, rows: Array) -> Polynomial:
        """The terms of a column for what is left of it ``# (rows,)``."""
        terms, columns, norms = self._pool(self.variables.sign_of(column))
        target = self.windows.averaged(rows)
        size = float(np.sqrt(np.mean(target**2))) or 1.0
        supports = beam_search(
            columns.T @ columns,
            columns.T @ (target / size),
            float(target @ target) / size**2,
            width=self.settings.width,
            branch=self.settings.branch,
            limit=self.settings.terms,
        )
        chosen = list(self._fewest(supports, columns, target / size))
        numbers = refit(columns[:, chosen], target, "l2") / norms[chosen]
        units = np.prod(self.scale ** terms.powers[chosen], axis=1)
        return Polynomial(terms.where(np.array(chosen, dtype=np.int64)), numbers / units)

    def _fewest(self, supports: Sequence[tuple[int, ...]], columns: Array, target: Array) -> tuple[int, ...]:
        """The smallest support whose error on held-out folds is within a standard error of the least."""
        errors = np.array([self._errors(columns[:, list(support)], target) for support in supports])
        best = errors[errors.mean(axis=1).argmin()]
        for support, error in zip(supports, errors, strict=True):
            worse = error - best
            if worse.mean() <= worse.std(ddof=1) / np.sqrt(len(worse)):
                return support
        raise AssertionError("the best support is within a standard error of itself")

    def _errors(self, columns: Array, target: Array) -> Array:
        """Mean squared error of every fold, by numbers that were fitted to the others ``# (folds,)``."""
        errors = []
        for fold in np.unique(self.fold):
            held = self.fold == fold
            numbers = refit(columns[~held], target[~held], "l2")
            errors.append(np.mean((target[held] - columns[held] @ numbers) ** 2))
        return np.array(errors)


def _size(window: int) -> int:
    """Rows of a block."""
    return max(BLOCK, 2 * window)


def _windows(transitions: Transitions, window: int) -> tuple[Rows, Rows]:
    """First row of every window that lies within a block of consecutive rows, and the block's number."""
    breaks = (np.diff(transitions.trajectory) != 0) | (np.diff(transitions.step) != 1)
    edges = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(transitions)]
    size = _size(window)
    blocks = [
        np.arange(begin, min(begin + size, end) - window + 1)
        for first, end in pairwise(edges)
        for begin in range(first, end - window + 1, size)
    ]
    numbered = [np.full(len(rows), number) for number, rows in enumerate(blocks)]
    none = np.zeros(0, dtype=np.int64)
    return np.concatenate([none, *blocks]), np.concatenate([none, *numbered])
