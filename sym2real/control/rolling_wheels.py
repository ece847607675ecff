"""Pure pursuit with wheels whose rates are commanded, in place of steering."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from sym2real.control.pure_pursuit import PurePursuit
from sym2real.protocols import Memoryless
from sym2real.robots import Robot
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array
from sym2real.vocabulary import rate_per_speed, rate_per_turn

ROLLING = (rate_per_speed, rate_per_turn)
SHARPEST = 1.2  # rad: of a front wheel one metre ahead that would turn the robot as sharply


@dataclass
class WheelPursuit(Memoryless):
    """A :class:`~sym2real.protocols.Controller` of a robot in a plane; it knows how its wheels roll, not a model.

    Args:
        robot: whose every command is the rate of a wheel that rolls.
        reference: full state wanted at a time in s.
    """

    robot: Robot
    reference: Reference
    _pursuit: PurePursuit = field(init=False)
    _rolling: Array = field(init=False)

    def __post_init__(self) -> None:
        numbers, action = self.robot.numbers, self.robot.layouts.action
        self._rolling = np.array([[numbers[name(column)] for name in ROLLING] for column in action])
        fastest = float((self.robot.high / np.abs(self._rolling[:, 0])).min())
        limits = np.array([SHARPEST, fastest])
        self._pursuit = PurePursuit(1.0, -limits, limits, self.robot.dt, self.reference)

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Rates of the wheels ``# (action,)``, rad/s, within the limits."""
        steer, speed = self._pursuit.act(state, step)
        wanted = self._rolling @ (speed, speed * np.tan(steer))
        clipped: Array = np.clip(wanted, self.robot.low, self.robot.high)
        return clipped


def rolls(robot: Robot) -> bool:
    """Whether every command is the rate of a wheel that rolls with the robot."""
    return all(name(column) in robot.numbers for column in robot.layouts.action for name in ROLLING)
