"""What time it is: the computer's monotonic clock, or one that a test sets."""

import time
from typing import Protocol

SPUN = 0.0005  # s: about as much later than asked a sleep ends, so that the rest is waited awake


class Clock(Protocol):
    """Seconds since some moment; never set back."""

    def now(self) -> float:
        """The present time in s."""

    def sleep_until(self, moment: float) -> None:
        """Return at a moment in s, at once where it has passed."""


class SystemClock:
    """The computer's monotonic clock."""

    def now(self) -> float:
        """The present time in s."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Return at a moment in s, at once where it has passed."""
        time.sleep(max(0.0, moment - SPUN - time.monotonic()))
        while time.monotonic() < moment:
            pass
