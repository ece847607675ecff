"""A series of numbers as one word of blocks: ▁▂▅█."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

BLOCKS = "▁▂▃▄▅▆▇█"


def sparkline(values: ArrayLike, width: int | None = None, highest: float | None = None) -> str:
    """Blocks from zero to the largest value; a space where a value is not finite.

    Args:
        values: not negative ``# (n,)``.
        width: number of blocks; the largest value of each piece is shown. One block a value by default.
        highest: of the scale; the largest value by default.
    """
    series = np.asarray(values, dtype=np.float64)
    if width is not None and len(series) > width:
        series = np.array([_largest(piece) for piece in np.array_split(series, width)])
    top = _largest(series) if highest is None else highest
    return "".join(_block(value, top) for value in series)


def _largest(values: Sequence[float] | np.ndarray) -> float:
    finite = np.asarray(values)[np.isfinite(values)]
    return float(finite.max()) if len(finite) else float("nan")


def _block(value: float, top: float) -> str:
    if not np.isfinite(value):
        return " "
    if not top > 0.0:
        return BLOCKS[0]
    return BLOCKS[min(len(BLOCKS) - 1, int(value / top * len(BLOCKS)))]
