"""Numbers for the page's script: 16 bits each, the differences of neighbours compressed, as text."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sym2real.trajectory import Array

GAP, LEVELS = -32768, 32767  # what stands for no number, and the largest step


class Arrays:
    """Named arrays; a chart names the one that it draws."""

    def __init__(self) -> None:
        self._directory: dict[str, dict[str, Any]] = {}
        self._parts: list[NDArray[np.int16]] = []
        self._size = 0

    def add(self, name: str, values: Array) -> str:
        """Put in an array whose last axis is drawn; the name it has.

        Resolution is a 65 000th of the range of a row of the last but one axis, over all others.

        Args:
            name: anything.
            values: ``# (..., n)``; a script sees no number as a gap.
        """
        rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
        over = tuple(axis for axis in range(rows.ndim) if axis != rows.ndim - 2)
        finite = np.where(np.isfinite(rows), rows, np.nan)
        low, high = _extremes(finite, over)
        scale = np.where(high > low, (high - low) / (2 * LEVELS), 1.0)
        middle = (high + low) / 2
        levels = np.round((finite - middle[:, None]) / scale[:, None])
        steps = np.where(np.isnan(levels), GAP, levels).astype(np.int16).ravel()
        directory = {"at": self._size, "shape": rows.shape, "scale": scale.tolist(), "middle": middle.tolist()}
        self._directory[name] = directory
        self._parts.append(steps)
        self._size += len(steps)
        return name

    @property
    def directory(self) -> dict[str, dict[str, Any]]:
        """By name: where an array begins, its shape, and per row the scale and the middle of its numbers."""
        return self._directory

    @property
    def text(self) -> str:
        """All arrays: base64 of the zlib stream of differences, low bytes first, then high bytes."""
        steps = np.concatenate(self._parts) if self._parts else np.zeros(0, dtype=np.int16)
        changes = np.diff(steps, prepend=np.int16(0)).astype("<i2")  # wraps around, and back in the script
        planes = changes.view(np.uint8).reshape(-1, 2).T.tobytes()
        return base64.b64encode(zlib.compress(planes, 6)).decode("ascii")


def _extremes(values: Array, over: tuple[int, ...]) -> tuple[Array, Array]:
    """Smallest and largest number along axes; zeros where there is none."""
    none = np.isnan(values).all(axis=over)
    low = np.where(np.isnan(values), np.inf, values).min(axis=over)
    high = np.where(np.isnan(values), -np.inf, values).max(axis=over)
    return np.where(none, 0.0, low), np.where(none, 0.0, high)
