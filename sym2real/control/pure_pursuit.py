"""Pure pursuit and speed for a car, forward and in reverse, and for wheels whose rates are commanded.

The car follows the arc that is tangent to its heading and passes through a point ahead on the reference,
(x, y) in body axes::

    κ = 2 y / (x² + y²),   steer = atan(L κ)

The same arc holds in reverse, where the point lies behind. The speed is the reference's, signed along the heading,
plus a gain times the distance still missing.
Source: R. C. Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import atan, copysign, hypot

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.control.at_steps import AtSteps
from sym2real.protocols import Memoryless
from sym2real.robots import Robot
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array
from sym2real.vocabulary import rate_per_speed, rate_per_turn

LEAST_REACH = 1e-6  # m; of the pursued point, where the car stands on it
STANDING = 0.05  # m/s: a reference slower than this is a place to park at, not a path to follow
ROLLING = (rate_per_speed, rate_per_turn)
SHARPEST = 1.2  # rad: of a front wheel one metre ahead that would turn a robot on wheels of given rates as sharply


@dataclass(frozen=True)
class PurePursuit(Memoryless):
    """Controller of test drives; it knows a wheelbase, not a model.

    Args:
        wheelbase: m.
        low: least action: steering in rad, speed in m/s ``# (2,)``.
        high: greatest action ``# (2,)``.
        dt: control period in s.
        reference: full state ``# (..., 7)`` wanted at a time in s ``# (...,)``: a task's, of time alone.
        lookahead: how far ahead in time the pursued point lies, s.
        gain: speed per distance missing, 1/s.
        tolerance: distance to a place to park at that counts as arrived, m.
    """

    wheelbase: float
    low: ArrayLike
    high: ArrayLike
    dt: float
    reference: Reference
    lookahead: float = 0.5
    gain: float = 1.5
    tolerance: float = 0.03

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Steering in rad and speed in m/s ``# (2,)`` for a state ``# (7,)`` at time ``step · dt``."""
        here, ahead = self._wanted[step]
        return self.towards(here, ahead, state)

    def towards(self, here: Sequence[float], ahead: Sequence[float], state: ArrayLike) -> Array:
        """The action for the reference's state now and the one that is pursued ``# (7,)``."""
        x, y, sine, cosine, *_ = np.asarray(state, dtype=np.float64).tolist()
        missing = forward_and_left((here[0] - x, here[1] - y), sine, cosine)
        target = forward_and_left((ahead[0] - x, ahead[1] - y), sine, cosine)
        pace = forward_and_left(here[4:6], sine, cosine)
        distance = hypot(*target)
        if hypot(*pace) < STANDING:
            speed = 0.0 if distance < self.tolerance else self.gain * copysign(distance, target[0])
        else:
            speed = copysign(hypot(*pace), pace[0]) + self.gain * missing[0]
        reach = max(distance, self.tolerance, LEAST_REACH)
        curvature = 2 * (target[1] / reach) / reach
        action: Array = np.clip([atan(self.wheelbase * curvature), speed], self.low, self.high)
        return action

    @cached_property
    def _wanted(self) -> AtSteps[list[list[float]]]:
        """The reference at a step, and where the pursued point lies."""
        ahead = torch.tensor([0.0, self.lookahead], dtype=torch.float64)
        return AtSteps(lambda times: self.reference(times[:, None] + ahead).to(torch.float64).tolist(), self.dt)


def forward_and_left(vector: Sequence[float], sine: float, cosine: float) -> tuple[float, float]:
    """World vector (x, y) in the axes of a car that points along (cosine, sine)."""
    x, y = vector
    return cosine * x + sine * y, cosine * y - sine * x


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
