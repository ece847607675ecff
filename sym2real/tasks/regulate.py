"""Bring a robot to a state and hold it there, whatever its joints are."""

from collections.abc import Mapping
from math import inf

import numpy as np
import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.task import Task, require_positive
from sym2real.trajectory import Array

DURATION = 8.0  # s
SPREAD = 0.1  # m, rad: of the coordinates of a start


def regulate(
    robot: Robot, goal: Mapping[str, float] | None = None, spread: float = SPREAD, duration: float = DURATION
) -> Task:
    """Go from near the robot's start to a goal.

    Args:
        robot: any.
        goal: what is wanted of state columns, in their units; the robot's start for those that are left out.
        spread: half the range of every coordinate about the start, where an episode begins, m and rad; at rest.
        duration: of an episode in s.

    Raises:
        UnknownNameError: for a column that the robot does not have.
        ShapeError: for a goal or spread that is no finite number, a goal beyond a joint's end stop, a spread below 0,
            or a duration that is not positive.
    """
    require_positive("regulate", duration=duration)
    layout, wanted = robot.layouts.state, robot.start.copy()
    ends = robot.ranges if goal else {}
    for column, value in (goal or {}).items():
        wanted[layout.index(column)] = value
        low, high = ends.get(column, (-inf, inf))
        if value < low or value > high:
            raise ShapeError(f"task 'regulate': expected {column} from {low:g} to {high:g}, its range, found {value:g}")
    if not (np.isfinite([spread, *wanted]).all() and spread >= 0.0):
        raise ShapeError(
            f"task 'regulate': expected finite numbers as goal, and a spread of at least 0, found {goal} and {spread}"
        )

    def reference(time: Tensor) -> Tensor:
        return torch.as_tensor(wanted, dtype=time.dtype).expand(*time.shape, -1)

    def start(rng: np.random.Generator) -> Array:
        state = robot.start.copy()
        places = [layout.index(column) for field in layout.placing for column in field.columns]
        state[places] += rng.uniform(-spread, spread, len(places))
        return state

    return Task("regulate", reference, tracking_cost(robot), start, duration)
