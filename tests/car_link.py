"""A car's link without ROS: MuJoCo behind a clock that the test owns."""

import math

import numpy as np
from numpy.typing import ArrayLike

from hardware.closing import Closing
from hardware.fakes.mushr import PERIOD, Car
from hardware.interfaces import Pose, Reading
from hardware.mushr import CarLimits
from hardware.mushr.pose_filter import PoseFilter
from sym2real.robots import MUSHR, Robot
from sym2real.trajectory import Array
from tests.hardware_link import TestClock


def pose(stamp: float, x: float, y: float, yaw: float) -> Pose:
    attitude = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
    return Pose(np.array([x, y, 0.0]), attitude, stamp, stamp)


class CarLink(Closing):
    """A :class:`~hardware.interfaces.RobotLink` to the fake car without ROS between; physics runs as the clock does."""

    def __init__(self, clock: TestClock, car: Car) -> None:
        self.clock, self.car, self.sent = clock, car, [np.zeros(2)]
        self.lost: float = math.inf  # when motion capture falls silent
        self._then, self._filter = clock.now(), PoseFilter()
        self._seen = pose(self._then, *car.advance(self._then))
        self._go_on(0.1)

    @property
    def robot(self) -> Robot:
        return MUSHR

    def connect(self) -> None:
        """Nothing to open."""

    def arm(self) -> None:
        """Nothing to unlock."""

    def state(self) -> Reading:
        self._go_on(0.0)
        return Reading(self.clock.now(), self._filter.state.copy(), {"pose": self.clock.now() - self._seen.arrival})

    def send(self, action: ArrayLike) -> Array:
        self._go_on(0.0)
        self.sent.append(CarLimits().reachable(np.asarray(action), self.sent[-1], MUSHR.dt))
        self.car.command("navigation", self.sent[-1], self.clock.now())
        return self.sent[-1].copy()

    def stop(self, *, emergency: bool = False) -> None:
        self.sent.append(np.zeros(2))
        self.car.command("navigation", self.sent[-1], self.clock.now())

    def close(self) -> None:
        self.stop()

    def _go_on(self, more: float) -> None:
        self.clock.time += more
        while self._then + PERIOD <= self.clock.now() + 1e-9:
            self._then += PERIOD
            seen = pose(self._then, *self.car.advance(self._then))
            if self._then < self.lost:
                self._seen = seen
                self._filter.add(seen)
