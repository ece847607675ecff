"""The fake's Kalman filter, as far as a link sees it: what its attitude is off by, and how sure it is of its position.

It has run since the robot was switched on, and was led astray. A reset ends that: gravity gives roll and pitch then,
and the yaw is what it is told.
"""

from scipy.spatial.transform import Rotation

from hardware.frame import heading
from sym2real.trajectory import Array

MOST = 100.0  # m²: the firmware's bound
TOLD = 1e-4  # m² of a position that it is told
ACCELERATION = 0.5  # m/s², what it takes to be noise where no position comes


class Estimator:
    """Made when the robot is switched on.

    Args:
        astray: what its attitude is off by until a reset, rotation vector in world axes, rad.
        now: present time, s.
    """

    def __init__(self, astray: tuple[float, float, float], now: float) -> None:
        self._off = Rotation.from_rotvec(astray)
        self._variance, self._then = MOST, now

    def reset(self, true: Array, yaw: float, now: float) -> None:
        """Begin anew, in a true attitude w x y z ``# (4,)``, with a yaw in rad that it is told."""
        self._off = Rotation.from_euler("z", yaw - heading(true))
        self._variance, self._then = MOST, now

    def tell(self, now: float) -> None:
        """A position has come."""
        before = self.variance(now)
        self._variance, self._then = before * TOLD / (before + TOLD), now

    def variance(self, now: float) -> float:
        """Of each axis of the position, m²."""
        return min(MOST, self._variance + ACCELERATION**2 * (now - self._then) ** 3 / 3.0)

    def attitude(self, true: Array) -> Array:
        """What it makes of a true attitude, both w x y z ``# (4,)``."""
        seen: Array = (self._off * Rotation.from_quat(true, scalar_first=True)).as_quat(scalar_first=True)
        return seen
