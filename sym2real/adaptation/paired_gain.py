"""Whether errors have become smaller, with the uncertainty of an answer from one log.

Errors of two models over the same windows of a log are compared pairwise. Neighbouring windows are alike, so the log is
cut into consecutive pieces longer than a window, and the interval is that of the delete-one-piece jackknife:
H. R. Künsch, "The jackknife and the bootstrap for general stationary observations", Annals of Statistics 17, 1989.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from sym2real.trajectory import Array

FEWEST_PIECES, MOST_PIECES = 3, 20
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Improvement:
    """Share of the mean error that is gone, with its 95 % interval; NaN and unbounded where a log is too short to say.

    Args:
        value: 1 - mean error after / mean error before; negative where errors have grown.
        low, high: ends of the interval, at most one: there is no more to gain than all of the error.
    """

    value: float = math.nan
    low: float = -math.inf
    high: float = math.inf

    @property
    def stalled(self) -> bool:
        """Whether there is an answer, and it is that nothing has become better beyond the interval."""
        return math.isfinite(self.low) and self.low <= 0.0

    @property
    def surely_better(self) -> bool:
        """Whether errors have shrunk beyond the interval."""
        return self.low > 0.0

    @property
    def surely_worse(self) -> bool:
        """Whether errors have grown beyond the interval."""
        return self.high < 0.0


def improvement(before: Array, after: Array, window: int) -> Improvement:
    """How much smaller errors have become.

    Args:
        before: of the one model, in the order of time ``# (errors,)``.
        after: of the other, on the same rows ``# (errors,)``.
        window: errors that overlap or hang together, which a piece must not be shorter than.
    """
    pieces = min(len(before) // max(1, window), MOST_PIECES)
    if pieces < FEWEST_PIECES or not before.any() or not np.isfinite([before, after]).all():
        return Improvement()
    value = 1.0 - float(after.mean() / before.mean())
    sums = [[piece.sum() for piece in np.array_split(values, pieces)] for values in (before, after)]
    earlier, later = np.array(sums)
    left_out = 1.0 - (later.sum() - later) / np.maximum(earlier.sum() - earlier, np.finfo(float).tiny)
    deviation = math.sqrt((pieces - 1) / pieces * float(np.square(left_out - left_out.mean()).sum()))
    half = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, pieces - 1)) * deviation
    return Improvement(value, value - half, min(1.0, value + half))
