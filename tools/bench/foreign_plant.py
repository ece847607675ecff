"""A plant on somebody else's simulator: the noisy sensors of the standard set, and commands that may arrive late."""

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from sym2real.experiments.standard_conditions import sensors
from sym2real.layout import Layouts
from sym2real.robots import Robot
from sym2real.trajectory import Array


class ForeignPlant(ABC):
    """A :class:`~sym2real.protocols.Plant` whose physics a subclass brings.

    Args:
        robot: whose state and actions it speaks.
        late: control periods that commands take to arrive.
        rng: of the sensors' noise.
    """

    crashed: bool = False

    def __init__(self, robot: Robot, late: int, rng: np.random.Generator) -> None:
        self._robot, self._late = robot, late
        self.layouts: Layouts = robot.layouts
        self.dt: float = robot.dt
        self.inputs: Array = np.zeros(len(robot.layouts.inputs))
        self._begin = sensors(robot, rng).measure

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start at a state ``# (state,)``; the measured one."""
        before = self._start(self._robot.start if state is None else np.asarray(state, dtype=np.float64))
        self._under_way = [before] * self._late
        self._measure = self._begin()
        return self._measure(self._true())

    def step(self, action: ArrayLike) -> Array:
        """Send an action ``# (action,)``; the measured state one period later ``# (state,)``."""
        self.sent: Array = np.array(action, dtype=np.float64)
        self._under_way.append(self.sent)
        self._hold(self._under_way.pop(0))
        return self._measure(self._true())

    @abstractmethod
    def _start(self, state: Array) -> Array:
        """Put the simulator into a state ``# (state,)``; the command under way there ``# (action,)``."""

    @abstractmethod
    def _hold(self, action: Array) -> None:
        """Simulate one control period under an action that has arrived ``# (action,)``."""

    @abstractmethod
    def _true(self) -> Array:
        """The state in our terms ``# (state,)``."""


def runge_kutta(slope: Callable[[Array], Array], state: Array, h: float) -> Array:
    """State ``# (n,)`` after ``h`` s by the classical step of fourth order."""
    first = slope(state)
    second = slope(state + h / 2 * first)
    third = slope(state + h / 2 * second)
    fourth = slope(state + h * third)
    return state + h / 6 * (first + 2 * second + 2 * third + fourth)
