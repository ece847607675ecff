"""A car's state from its poses: median, yaw without its turns, velocity over the stamps' own intervals."""

import math
from collections import deque

import numpy as np

from hardware.frame import heading
from hardware.interfaces import Pose
from hardware.velocity import TOGETHER, Velocity
from sym2real.trajectory import Array

MEDIAN = 3  # poses: one outlier passes nowhere, at the price of one pose's delay
WINDOW = 0.048  # s: about a control period at 20 Hz
GAP = 0.25  # s without a pose, after which nothing before it counts


class PoseFilter:
    """State ``x y sin_yaw cos_yaw vx vy wz`` of the newest poses; NaN where not enough is known yet."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, Array]] = deque(maxlen=MEDIAN)
        self._velocity = Velocity(WINDOW, shortest=TOGETHER, longest=GAP)  # the stamps are the cameras' own
        self._yaw = 0.0
        self.state = np.full(7, math.nan)

    def add(self, pose: Pose) -> Array:
        """The state ``# (7,)`` with a pose. A stamp that has been seen, or a pose without heading, changes nothing."""
        if pose.attitude is None or (self._recent and pose.stamp == self._recent[-1][0]):
            return self.state
        if self._recent and not 0.0 < pose.stamp - self._recent[-1][0] < GAP:
            self._recent.clear()
        place = np.array([*pose.position[:2], self._unwrapped(heading(pose.attitude))])
        self._recent.append((pose.stamp, place))
        stamp, (x, y, yaw) = self._median()
        vx, vy, wz = self._velocity.add(stamp, np.array([x, y, yaw]))
        self.state = np.array([x, y, math.sin(yaw), math.cos(yaw), vx, vy, wz])
        return self.state

    def _unwrapped(self, yaw: float) -> float:
        """The yaw nearest to the last one's, so that medians and slopes do not see whole turns."""
        self._yaw += math.remainder(yaw - self._yaw, 2.0 * math.pi)
        return self._yaw

    def _median(self) -> tuple[float, Array]:
        """Of the recent poses, with the stamp in their middle."""
        stamps, places = zip(*self._recent, strict=True)
        return float(np.median(stamps)), np.median(np.array(places), axis=0)
