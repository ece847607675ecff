"""The firmware's supervisor, as far as a link can see it: armed, flying, tumbled, locked, crashed."""

from sym2real.trajectory import Array

PREFLIGHT = 30.0  # s that it stays armed on the ground
TUMBLE = 0.1  # s upside down
FLYING_COUNTS = 7000
BITS = {"can_be_armed": 0, "armed": 1, "can_fly": 3, "flying": 4, "tumbled": 5, "locked": 6, "crashed": 7}


class Supervisor:
    """Says whether motors may turn.

    Args:
        now: present time, s.
    """

    def __init__(self, now: float) -> None:
        self.armed = self.flying = self.tumbled = self.locked = False
        self._since, self._upright = now, now

    def arm(self, wanted: bool, now: float) -> bool:
        """A request to arm or disarm; whether it is as wanted then."""
        self.armed = wanted and not (self.locked or self.tumbled)
        self._since = now
        return self.armed == wanted

    def lock(self) -> None:
        """An emergency stop, or a set-point that stayed away in flight: off until a restart."""
        self.locked, self.armed, self.flying = True, False, False

    def lock_in_flight(self) -> None:
        """Lock where it flies; on the ground nothing has happened."""
        if self.flying:
            self.lock()

    def allows(self, now: float, counts: int, state: Array) -> bool:
        """Whether motors turn at a set-point of so many counts, in a true state ``# (13,)``."""
        up = 1.0 - 2.0 * float(state[4] ** 2 + state[5] ** 2)
        self._upright = now if up > 0.0 else self._upright
        if self.flying and now - self._upright > TUMBLE:
            self.tumbled, self.armed = True, False
        turning = self.armed and counts > 0
        self.flying = turning and counts > FLYING_COUNTS
        if self.flying:
            self._since = now
        if self.armed and now - self._since > PREFLIGHT:
            self.armed = False
        return turning

    @property
    def bits(self) -> int:
        """The firmware's bit field."""
        stuck = self.locked or self.tumbled
        said = {
            "can_be_armed": not stuck,
            "armed": self.armed,
            "can_fly": self.armed and not stuck,
            "flying": self.flying,
            "tumbled": self.tumbled,
            "locked": self.locked,
            "crashed": self.tumbled,
        }
        return sum(1 << BITS[name] for name, holds in said.items() if holds)
