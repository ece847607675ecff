"""A series of numbers as one word of blocks: ▁▂▅█."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

BLOCKS = "▁▂▃▄▅▆▇█"


def sparkline(values: ArrayLike, highest: float | None = None) -> str:
    """Blocks from zero to the largest value; a space where a value is not finite.

    Args:
        values: not negative ``# (n,)``.
        highest: of the scale; the largest value by default.
    """
    series = np.asarray(values, dtype=np.float64)
    top = float(series[np.isfinite(series)].max(initial=0.0)) if highest is None else highest
    return "".join(_block(value, top) for value in series)


def _block(value: float, top: float) -> str:
    if not np.isfinite(value):
        return " "
    if not top > 0.0:
        return BLOCKS[0]
    return BLOCKS[min(len(BLOCKS) - 1, int(value / top * len(BLOCKS)))]
