"""Whether a series stays at its smallest or largest value, as one does that is clipped.

Some row is always the largest, so a share of rows alone says nothing of a short log. A clipped value stays where it is
cut off, while a free one keeps a value no longer than its source does: a command that is sent every second row keeps
each for two. A stay is therefore a run of equal rows more than twice as long as the series' usual one.
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
    between = (values > values.min()) & (values < values.max())
    stays = lengths > STAY * np.median(lengths[between] if between.any() else lengths)
    low, high = (
        float(lengths[stays & (values == edge)].sum() / lengths.sum()) for edge in (values.min(), values.max())
    )
    return low, high


def _runs(piece: Array) -> tuple[Array, NDArray[np.int64]]:
    """Values of runs of equal rows, and the lengths of the runs."""
    first = np.flatnonzero(np.diff(piece, prepend=np.nan) != 0)
    return piece[first], np.diff(first, append=len(piece))
