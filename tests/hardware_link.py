"""A robot link without a link: MuJoCo behind a clock that the test owns, with faults that the test switches on."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hardware.closing import Closing
from hardware.interfaces import Reading
from sym2real.plants import MujocoPlant
from sym2real.protocols import Change
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.trajectory import Array

ON_THE_GROUND = np.array([0.1, -0.2, 0.0125, 1.0, *[0.0] * 9])


class TestClock:
    """Stands still until somebody sleeps."""

    __test__ = False

    def __init__(self) -> None:
        self.time = 100.0
        self.late = 0.0  # s by which the next sleep ends too late

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time, self.late = max(self.time, moment) + self.late, 0.0


class SimulatedLink(Closing):
    """A :class:`~hardware.interfaces.RobotLink` to a simulated Crazyflie; physics runs as the clock does."""

    def __init__(self, clock: TestClock, changes: Sequence[Change] = (), start: Array = ON_THE_GROUND) -> None:
        self.clock, self.armed, self.stopped, self.emergency = clock, False, False, False
        self.plant = MujocoPlant(replace(CRAZYFLIE, dt=CRAZYFLIE.description.physics_dt), changes)
        self.plant.reset(start)
        self._then, self._action = clock.now(), np.zeros(4)
        self.sent: list[Array] = []
        self.battery, self.flags = 4.0, {"can_fly"}
        self.lost: dict[str, float] = {}  # source → when it fell silent

    @property
    def robot(self) -> Robot:
        return CRAZYFLIE

    def connect(self) -> None:
        """Nothing to open."""

    def arm(self) -> None:
        self.armed, self.stopped = True, False

    def state(self) -> Reading:
        while self._then < self.clock.now() - 1e-9:
            self.plant.step(self._action)
            self._then += CRAZYFLIE.description.physics_dt
        now = self.clock.now()
        ages = {name: now - self.lost.get(name, now) for name in ("pose", "attitude")}
        return Reading(now, self.plant.true_state, ages, self.battery, frozenset(self.flags))

    def send(self, action: ArrayLike) -> Array:
        assert self.armed
        self.state()
        self._action = np.asarray(action, dtype=np.float64)
        self.sent.append(self._action)
        return self._action * [0.99, 1.0, 1.0, 1.0]  # what was asked and what was sent are told apart

    def stop(self, *, emergency: bool = False) -> None:
        self.state()
        self._action, self.stopped, self.armed = np.zeros(4), True, False
        self.emergency = self.emergency or emergency

    def close(self) -> None:
        self.stop()
