"""Rows of logs that evidence is taken from: enough that more would say the same, and no more; and what they say.

Rows faster than :data:`RATE` only add noise to slopes. Of hours of recording, stretches are looked at that stand evenly
over the log: slopes and delays need rows in a row, and one stretch alone may be the one on the ground. A column of
evidence is one array, stretch behind stretch; each stretch has its own mean.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from sym2real.logs import derive
from sym2real.trajectory import Array

RATE = 100.0  # rows a second
STRETCHES, LENGTH = 10, 3000  # of a log; rows of evidence in each, half a minute at that rate
SMOOTHING = 5  # rows
LONGEST_DELAY = 0.5  # s


class Stretch(NamedTuple):
    """Rows of one log.

    Args:
        log: which, counted from 0.
        rows: first row, row after the last, and stride.
    """

    log: int
    rows: slice


def stretches(times: Sequence[Array]) -> list[Stretch]:
    """The rows to look at in logs with these stamps in s ``# (rows,)``: the whole of a log that is short enough."""
    stretches = []
    for log, time in enumerate(times):
        stride = max(1, round(1.0 / (RATE * float(np.median(np.diff(time))))))
        length = LENGTH * stride
        if len(time) <= STRETCHES * length:
            stretches.append(Stretch(log, slice(0, len(time), stride)))
            continue
        firsts = np.linspace(0, len(time) - length, STRETCHES).astype(int).tolist()
        stretches += [Stretch(log, slice(first, first + length, stride)) for first in firsts]
    return stretches


def words(times: Sequence[Array], looked_at: Sequence[Stretch]) -> str:
    """What is looked at, for people; empty where it is every row."""
    used = sum(len(times[log][rows]) for log, rows in looked_at)
    whole = sum(map(len, times))
    if used == whole:
        return ""
    strides = sorted({rows.step for _, rows in looked_at})
    every = "" if strides == [1] else f"every {' to '.join(f'{stride}th' for stride in strides)} row"
    cut = len(looked_at) > len(times)
    parts = f"{STRETCHES} stretches of {LENGTH} rows, evenly over {'each long' if len(times) > 1 else 'the'} log"
    how = ", ".join(part for part in (every, parts if cut else "") if part)
    return f"{used} of {whole} rows ({how}) tell slopes, units and delays; stamps, limits and empty cells are of all"


class Rows:
    """The rows that are looked at in logs with these stamps in s ``# (rows,)``.

    Columns are ``# (rows,)``, or ``# (rows, k)`` where it says so; numbers are of smoothed columns about their means.
    """

    def __init__(self, times: Sequence[Array]) -> None:
        self.stretches = stretches(times)
        self.stamps = self.of(times)
        self._cuts = np.cumsum([len(times[log][rows]) for log, rows in self.stretches])[:-1]

    def of(self, logs: Sequence[Array]) -> Array:
        """These rows of a column of every log."""
        return np.concatenate([logs[log][rows] for log, rows in self.stretches])

    def parts(self, column: Array) -> list[Array]:
        """A column's stretches."""
        return np.split(column, self._cuts)

    def each(self, function: Callable[..., Array], *columns: Array) -> Array:
        """What a function makes of each stretch of columns."""
        return np.concatenate([function(*parts) for parts in zip(*map(self.parts, columns), strict=True)])

    def slopes(self, column: Array) -> Array:
        """Rates of change per second, also of ``# (rows, k)``."""
        return self.each(derive.slope, self.stamps, column)

    def correlation(self, first: Array, second: Array, late: int = 0) -> float:
        """Pearson's, where the second follows by so many rows; 0 where one of them does not move."""
        early = [part[: len(part) - late] for part in self.parts(first)]
        later = [part[late:] for part in self.parts(second)]
        a, b = _moving(early), _moving(later)
        size = float(np.linalg.norm(a) * np.linalg.norm(b))
        return float(a @ b) / size if size > 0 else 0.0

    def spread(self, columns: Array) -> float:
        """Standard deviation; of ``# (rows, k)`` the sum of the columns'."""
        return sum(float(np.std(_moving(self.parts(column)))) for column in np.atleast_2d(columns.T))

    def ratio(self, first: Array, second: Array) -> float:
        """How many times larger the first move than the second: the geometric mean slope, which noise does not bend."""
        below = self.spread(second)
        return self.spread(first) / below if below > 0 else float("inf")

    def moving(self, columns: Array) -> Array:
        """Columns ``# (rows, k)``, smoothed, about the means of their stretches, without ends that smoothing spoils."""
        return np.stack([_moving(self.parts(column)) for column in columns.T], axis=1)

    def delay(self, command: Array, response: Array) -> tuple[float, float]:
        """By how many seconds a response follows a command, and the correlation there: the highest of all delays."""
        step = float(np.median(np.diff(self.parts(self.stamps)[0])))
        longest = min(map(len, self.parts(command))) - 4 * SMOOTHING
        best, peak = 0, 0.0
        for late in range(min(max(1, int(LONGEST_DELAY / step)) + 1, longest)):
            found = self.correlation(command, response, late)
            if abs(found) > abs(peak) + 1e-3:
                best, peak = late, found
        return best * step, peak


def _moving(parts: Sequence[Array]) -> Array:
    kernel = np.ones(SMOOTHING) / SMOOTHING
    smooth = [np.convolve(part, kernel, mode="same") if len(part) >= SMOOTHING else part for part in parts]
    cut = [part[SMOOTHING:-SMOOTHING] if len(part) > 4 * SMOOTHING else part for part in smooth]
    return np.concatenate([part - part.mean() for part in cut])
