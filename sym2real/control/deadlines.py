"""How long actions took, against the control period: counts in fixed memory, for a loop that runs for hours."""

from __future__ import annotations

import math

from sym2real.errors import ShapeError

# Bins of a logarithmic histogram: each 5 % wider than the one before, from 10 µs to 30 s.
SHORTEST, RATIO, BINS = 1e-5, 1.05, 306


class Deadlines:
    """Durations of actions.

    Args:
        period: s; an action that takes longer is a miss.

    Raises:
        ShapeError: for a period that is not positive.
    """

    def __init__(self, period: float) -> None:
        if not period > 0.0:
            raise ShapeError(f"expected a control period > 0 s, found {period!r}")
        self.period = period
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.count = 0
        self.missed = 0
        self.worst = 0.0  # s
        self._bins = [0] * BINS

    def note(self, seconds: float) -> bool:
        """One more action took so long; whether that was too long."""
        self.count += 1
        missed = seconds > self.period
        self.missed += missed
        self.worst = max(self.worst, seconds)
        place = math.log(max(seconds, SHORTEST) / SHORTEST) / math.log(RATIO)
        self._bins[min(int(place), BINS - 1)] += 1
        return missed

    def quantile(self, share: float) -> float:
        """Duration in s that this share of the actions did not exceed, to 5 %; 0 before the first one."""
        wanted, seen = share * self.count, 0
        for place, number in enumerate(self._bins):
            seen += number
            if number and seen >= wanted:
                return min(SHORTEST * RATIO ** (place + 1), self.worst)
        return 0.0
