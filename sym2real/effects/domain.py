"""Values that an effect's parameter can have at all, beyond which there is no such thing: no delay is negative."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Domain:
    """An interval of real numbers.

    Args:
        low, high: its ends.
        open: whether ``low`` itself is outside.
    """

    low: float = -math.inf
    high: float = math.inf
    open: bool = False

    def __contains__(self, value: float) -> bool:
        return math.isfinite(value) and (value > self.low if self.open else value >= self.low) and value <= self.high

    def nearest(self, value: float) -> float:
        """The value, or the end of the interval that it lies beyond."""
        return min(max(value, self.low), self.high)

    def __str__(self) -> str:
        """For a sentence, without a unit."""
        low = "" if self.low == -math.inf else f"{'more than' if self.open else 'at least'} {self.low:g}"
        high = "" if self.high == math.inf else f"at most {self.high:g}"
        return " and ".join(part for part in (low, high) if part) or "a finite number"


ANYTHING = Domain()
NOT_NEGATIVE = Domain(0.0)
LONGEST_DELAY = 60.0  # s; every row that is still under way is kept, so that a delay without end fills the memory
DELAY_TIME = Domain(0.0, LONGEST_DELAY)
SHIFT_TIME = Domain(-LONGEST_DELAY, LONGEST_DELAY)
POSITIVE = Domain(0.0, open=True)
