"""Rows of logs that evidence is taken from, and what they say; rows faster than :data:`RATE` only add noise to slopes.

A column of evidence is one array, log behind log; each log has its own mean.
"""

from collections.abc import Callable, Sequence

import numpy as np

from sym2real.logs import derive
from sym2real.trajectory import Array

RATE = 100.0  # rows a second
SMOOTHING = 5  # rows


class Rows:
    """The rows that are looked at in logs with these stamps in s ``# (rows,)``.

    Columns are ``# (rows,)``, or ``# (rows, k)`` where it says so; numbers are of smoothed columns about their means.
    """

    def __init__(self, times: Sequence[Array]) -> None:
        self._strides = [max(1, round(1.0 / (RATE * float(np.median(np.diff(time)))))) for time in times]
        self.stamps = self.of(times)
        self._cuts = np.cumsum([len(time[::stride]) for time, stride in zip(times, self._strides, strict=True)])[:-1]

    def of(self, logs: Sequence[Array]) -> Array:
        """These rows of a column of every log."""
        return np.concatenate([values[::stride] for values, stride in zip(logs, self._strides, strict=True)])

    def parts(self, column: Array) -> list[Array]:
        """A column's logs."""
        return np.split(column, self._cuts)

    def each(self, function: Callable[..., Array], *columns: Array) -> Array:
        """What a function makes of each log's part of columns."""
        return np.concatenate([function(*parts) for parts in zip(*map(self.parts, columns), strict=True)])

    def slopes(self, column: Array) -> Array:
        """Rates of change per second, also of ``# (rows, k)``."""
        return self.each(derive.slope, self.stamps, column)

    def correlation(self, first: Array, second: Array) -> float:
        """Pearson's; 0 where one of them does not move."""
        a, b = _moving(self.parts(first)), _moving(self.parts(second))
        size = float(np.linalg.norm(a) * np.linalg.norm(b))
        return float(a @ b) / size if size > 0 else 0.0

    def spread(self, columns: Array) -> float:
        """Standard deviation; of ``# (rows, k)`` the sum of the columns'."""
        return sum(float(np.std(_moving(self.parts(column)))) for column in np.atleast_2d(columns.T))

    def ratio(self, first: Array, second: Array) -> float:
        """How many times larger the first move than the second: the geometric mean slope, which noise does not bend."""
        below = self.spread(second)
        return self.spread(first) / below if below > 0 else float("inf")

    def mean(self, column: Array) -> float:
        """Mean without the ends of logs, where a slope is mostly noise."""
        return float(np.concatenate([_inside(part) for part in self.parts(column)]).mean())

    def moving(self, columns: Array) -> Array:
        """Columns ``# (rows, k)``, smoothed, about the means of their logs, without ends that smoothing spoils."""
        return np.stack([_moving(self.parts(column)) for column in columns.T], axis=1)


def _moving(parts: Sequence[Array]) -> Array:
    kernel = np.ones(SMOOTHING) / SMOOTHING
    smooth = [np.convolve(part, kernel, mode="same") if len(part) >= SMOOTHING else part for part in parts]
    return np.concatenate([part - part.mean() for part in map(_inside, smooth)])


def _inside(part: Array) -> Array:
    return part[SMOOTHING:-SMOOTHING] if len(part) > 4 * SMOOTHING else part
