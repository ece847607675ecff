"""Hover upright at a point with yaw 0."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.path import HEIGHT, along, at_rest, episode_length
from sym2real.tasks.task import Reference, Task, require, require_numbers
from sym2real.trajectory import Array

START = (0.0, 0.0, HEIGHT)
# The paper's test volume of 0.6 × 0.6 × 1 m, around the point where training hovers.
UNSEEN_LOW, UNSEEN_HIGH = (-0.3, -0.3, 0.5), (0.3, 0.3, 1.5)


def hover(robot: Robot, goal: Sequence[float] = START, start: Sequence[float] = START) -> Task:
    """Go to a point and stay there.

    Args:
        robot: a quadrotor.
        goal: where to hover, m, world axes.
        start: where the episode starts, upright and at rest, m, world axes.

    Raises:
        ShapeError: when the robot has no attitude, or a place is not three numbers.
    """
    require(robot, "attitude", "hover")
    reference = standing(robot, goal)
    first = at_rest(standing(robot, start), robot)
    return Task("hover", reference, tracking_cost(robot), lambda rng: first.copy(), episode_length(robot))


def unseen_goal(rng: np.random.Generator) -> Array:
    """A goal ``# (3,)`` in m, uniform in the volume where the paper tests a model that has only hovered at a point."""
    return rng.uniform(UNSEEN_LOW, UNSEEN_HIGH)


def standing(robot: Robot, point: Sequence[float]) -> Reference:
    """Reference that stays upright at a point."""
    x, y, z = require_numbers("hover", "a point", point, 3)

    def path(time: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        zero = torch.zeros_like(time)
        still = torch.stack([zero, zero], dim=-1)
        return torch.stack([zero + x, zero + y], dim=-1), still, still

    return along(path, robot, height=z)
