"""Numbers for the page's script: 16 bits each, the differences of neighbours compressed, as text."""

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sym2real.trajectory import Array

GAP, LEVELS = -32768, 32767  # what stands for no number, and the largest step


class Arrays:
    """Arrays by their number; ``directory`` says of each where it begins, and the scale and middle of its rows."""

    def __init__(self) -> None:
        self.directory: list[dict[str, Any]] = []
        self._parts: list[NDArray[np.int16]] = []
        self._known: dict[int, tuple[int, Array]] = {}  # the arrays too: no other may get the address of one

    def add(self, values: Array) -> int:
        """Put in an array, once; its number.

        Resolution is a 65 000th of the range of a row.

        Args:
            values: ``# (n,)`` or ``# (rows, n)``; a script sees no number as a gap.
        """
        if id(values) in self._known:
            return self._known[id(values)][0]
        rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
        finite = np.where(np.isfinite(rows), rows, np.nan)
        low, high = (np.nan_to_num(end.reduce(finite, axis=1, initial=np.nan)) for end in (np.fmin, np.fmax))
        scale = np.where(high > low, (high - low) / (2 * LEVELS), 1.0)
        middle = (high + low) / 2
        levels = np.round((finite - middle[:, None]) / scale[:, None])
        begin = sum(map(len, self._parts))
        about = {"at": begin, "length": rows.shape[1], "scale": scale.tolist(), "middle": middle.tolist()}
        self._parts.append(np.where(np.isnan(levels), GAP, levels).astype(np.int16).ravel())
        self.directory.append(about)
        self._known[id(values)] = len(self.directory) - 1, values
        return len(self.directory) - 1

    @property
    def text(self) -> str:
        """All arrays: base64 of the zlib stream of differences, low bytes first, then high bytes."""
        steps = np.concatenate([np.zeros(0, dtype=np.int16), *self._parts])
        changes = np.diff(steps, prepend=np.int16(0)).astype("<i2")  # wraps around, and back in the script
        planes = changes.view(np.uint8).reshape(-1, 2).T.tobytes()
        return base64.b64encode(zlib.compress(planes, 6)).decode("ascii")
