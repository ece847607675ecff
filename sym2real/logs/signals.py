"""Numbers that evidence is made of: several logs at once, each with its own stamps and its own mean."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sym2real.logs import derive
from sym2real.trajectory import Array

Series = list[Array]  # one array per log

SMOOTHING = 5  # rows


def smooth(series: Series) -> Series:
    """Moving averages over :data:`SMOOTHING` rows."""
    kernel = np.ones(SMOOTHING) / SMOOTHING
    return [np.convolve(values, kernel, mode="same") if len(values) >= SMOOTHING else values for values in series]


def slopes(times: Series, series: Series) -> Series:
    """Rates of change per second."""
    return [derive.slope(time, values) for time, values in zip(times, series, strict=True)]


def centred(series: Sequence[Array]) -> Array:
    """All logs in one array, each without its mean and without the rows at its ends that smoothing spoils."""
    cut = [values[SMOOTHING:-SMOOTHING] if len(values) > 4 * SMOOTHING else values for values in series]
    return np.concatenate([values - values.mean() for values in cut])


def correlation(first: Series, second: Series) -> float:
    """Pearson's correlation of smoothed signals, each log about its own mean; 0 where one of them does not move."""
    a, b = centred(smooth(first)), centred(smooth(second))
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0 else 0.0


def spread(series: Series) -> float:
    """Standard deviation of smoothed signals, each log about its own mean."""
    return float(np.std(centred(smooth(series))))


def ratio(first: Series, second: Series) -> float:
    """How many times larger the first moves than the second: the geometric mean slope, which noise does not bend."""
    below = spread(second)
    return spread(first) / below if below > 0 else float("inf")


def largest(series: Series) -> float:
    """Largest magnitude."""
    return max(float(np.abs(values).max()) for values in series)


def mean(series: Series) -> float:
    """Mean over all rows of all logs."""
    return float(np.concatenate(series).mean())


def delay(command: Series, response: Series, steps: int) -> tuple[int, float]:
    """By how many rows the response follows the command, at most ``steps``, and the correlation there.

    The peak of the cross-correlation of the two, each log about its own mean.
    """
    best, peak = 0, 0.0
    for shift in range(steps + 1):
        if shift >= min(len(values) for values in command) - 4 * SMOOTHING:
            break
        early = [values[: len(values) - shift] for values in command]
        late = [values[shift:] for values in response]
        found = correlation(early, late)
        if abs(found) > abs(peak) + 1e-3:
            best, peak = shift, found
    return best, peak
