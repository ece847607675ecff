"""Whether a series stays at its smallest or largest value, as one does that is clipped, and whether it alternates.

Some row is always the largest, so a share of rows alone says nothing of a short log. A clipped value stays where it is
cut off, while a free one keeps a value no longer than its source does: a command that is sent every second row keeps
each for two, steps keep theirs for a second. A stay is therefore a run of equal rows more than twice as long as the
usual one of its log.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sym2real.trajectory import Array

STAY = 2.0  # in usual runs


def at_extremes(pieces: Sequence[Array]) -> tuple[float, float]:
    """Parts of all rows in which a series stays at its smallest and at its largest value.

    Args:
        pieces: the series, without NaN, one piece per log ``# (rows,)``.
    """
    runs = [_runs(piece) for piece in pieces if len(piece)]
    values, lengths = (np.concatenate(parts) for parts in zip(*runs, strict=True))
    ends = values.min(), values.max()
    usual = _usual(values, lengths, ends) or float(np.median(lengths))
    longest = np.concatenate([np.full(len(own), STAY * (_usual(own, run, ends) or usual)) for own, run in runs])
    low, high = (float(lengths[(lengths > longest) & (values == end)].sum() / lengths.sum()) for end in ends)
    return low, high


def reversal(pieces: Sequence[Array]) -> float:
    """Correlation of a series' changes with those a row later; 0 where it never changes.

    Of what is drawn anew for every row it is -1/2, and -1 where every second row undoes what the one before did.
    """
    changes = [np.diff(piece) for piece in pieces]
    squares = float(sum(change @ change for change in changes))
    return float(sum(change[1:] @ change[:-1] for change in changes)) / squares if squares else 0.0


def _usual(values: Array, lengths: NDArray[np.int64], ends: tuple[float, float]) -> float:
    """Median length of the runs between both ends; 0 where there are none."""
    between = (values > ends[0]) & (values < ends[1])
    return float(np.median(lengths[between])) if between.any() else 0.0


def _runs(piece: Array) -> tuple[Array, NDArray[np.int64]]:
    """Values of runs of equal rows, and the lengths of the runs."""
    first = np.flatnonzero(np.diff(piece, prepend=np.nan) != 0)
    return piece[first], np.diff(first, append=len(piece))
