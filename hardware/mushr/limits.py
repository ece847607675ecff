"""What a car's drivers take: steering, speed and how fast they may change."""

from dataclasses import dataclass

import numpy as np

from sym2real.trajectory import Array


@dataclass(frozen=True)
class CarLimits:
    """Limits of what is sent.

    The defaults are the stock MuSHR's: its speed controller takes 3250 of its units, 3500 to a m/s; its servo turns by
    3.2 rad/s.

    Args:
        steer: greatest angle to either side, rad.
        forward: greatest speed, m/s.
        reverse: greatest speed backwards, m/s.
        steer_rate: at which the steering may change, rad/s.
        acceleration: at which the speed may change, m/s².
    """

    steer: float = 0.38
    forward: float = 0.93
    reverse: float = 0.93
    steer_rate: float = 3.2
    acceleration: float = 2.5

    def reachable(self, wanted: Array, before: Array, seconds: float) -> Array:
        """The action ``# (2,)`` nearest to a wanted one that the limits allow.

        Args:
            wanted: steering in rad, speed in m/s ``# (2,)``; finite.
            before: what was sent last ``# (2,)``.
            seconds: since then.
        """
        step = max(seconds, 0.0) * np.array([self.steer_rate, self.acceleration])
        inside = np.clip(wanted, [-self.steer, -self.reverse], [self.steer, self.forward])
        reached: Array = np.clip(inside, before - step, before + step)
        return reached
