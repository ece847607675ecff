"""The geometric controller of a robot, which knows a mass or a wheelbase and no model, with or without disturbance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sym2real.control.geometric_quadrotor import GeometricQuadrotor
from sym2real.control.linear_quadratic import LinearQuadratic
from sym2real.control.pure_pursuit import PurePursuit, WheelPursuit, rolls
from sym2real.protocols import Controller
from sym2real.robots import Robot
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array
from sym2real.vocabulary import RATE_COMMAND, SPEED_COLUMN, STEER_COLUMN, THRUST_COLUMN


def geometric_controller(robot: Robot, reference: Reference) -> Controller:
    """Tracks a reference ``# (..., state)`` in time (s) with the nominal robot's numbers.

    By what is commanded: thrust and rates, steering and speed, or the rates of wheels that roll; of any other robot, a
    linear-quadratic regulator on its nominal equations.

    Raises:
        ModelError: for another robot that has no such equations, or that they cannot hold.
    """
    action = robot.layouts.action
    if THRUST_COLUMN in action and action.has_field(RATE_COMMAND.name):
        return GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference)
    if STEER_COLUMN in action and SPEED_COLUMN in action:
        wheelbase = robot.numbers["wheelbase"]
        return PurePursuit(wheelbase, robot.low, robot.high, robot.dt, reference)
    return WheelPursuit(robot, reference) if rolls(robot) else LinearQuadratic(robot, reference)


@dataclass(frozen=True)
class Disturbed:
    """A controller with something on top of its commands, within limits.

    Args:
        controller: what is disturbed.
        added: to the action of a step ``# (action,)``.
        low, high: limits of the sum ``# (action,)``.
    """

    controller: Controller
    added: Callable[[int], Array]
    low: Array
    high: Array

    def reset(self) -> None:
        """Begin an episode."""
        self.controller.reset()

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """The controller's action with what is added, within the limits ``# (action,)``."""
        wanted = self.controller.act(state, step, inputs)
        return np.clip(wanted + self.added(step), self.low, self.high)

    def remember(self, sent: ArrayLike) -> None:
        """Tell the controller what was sent."""
        self.controller.remember(sent)
