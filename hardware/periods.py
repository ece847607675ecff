"""Control periods on a grid of the clock that never drifts."""

import math

from hardware.clock import Clock


class Periods:
    """When control periods are due, and which went by.

    Args:
        clock: tells the time.
        dt: of a period, s.

    Attributes:
        began: when the present one began, s.
        due: when it was due; once it is over, when the next is, s.
        skipped: periods left out before the present one.
        missed: all that were left out.
    """

    def __init__(self, clock: Clock, dt: float) -> None:
        self._clock, self._dt = clock, dt
        self.began = self.due = 0.0
        self.skipped = self.missed = 0

    @property
    def late(self) -> float:
        """By how much the present one began too late, s."""
        return self.began - self.due

    @property
    def taken(self) -> float:
        """How long the present one has lasted, s."""
        return self._clock.now() - self.began

    def begin(self) -> None:
        """A period begins now."""
        self.began = self._clock.now()

    def restart(self) -> None:
        """A period begins now, and the grid with it."""
        self.begin()
        self.due = self.began

    def finish(self) -> None:
        """The next one is due; those that have gone by already are left out, and counted."""
        self.due += self._dt
        # From one measurement to the next at least half a period passes.
        self.skipped = max(0, math.ceil((self.began - self.due) / self._dt + 0.5))
        self.missed += self.skipped
        self.due += self.skipped * self._dt

    def wait(self) -> None:
        """Sleep until the next one is due."""
        self._clock.sleep_until(self.due)

    def overdue(self) -> float:
        """How long ago the action of the present one should have come, s; below zero while there is time."""
        return self._clock.now() - max(self.began, self.due) - self._dt
