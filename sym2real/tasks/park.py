"""Park a car at (1, 0) with yaw 0, from starts seen in training or from beyond the goal."""

from collections.abc import Sequence

import numpy as np
from torch import Tensor

from sym2real.registry import Registry
from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.path import car_at_rest, episode_length
from sym2real.tasks.task import Task, require, require_numbers
from sym2real.trajectory import Array

# Where a car may stand at the start: a range of x in m, within ± of y in m and of yaw in rad. The paper trains on one
# region and tests on the other, which asks for driving backwards.
START_REGIONS = Registry("start region", {"seen": (-1.0, -0.5), "unseen": (2.5, 3.0)})
START_Y, START_YAW = 1.0, float(np.deg2rad(45.0))


def park(robot: Robot, goal: Sequence[float] = (1.0, 0.0), yaw: float = 0.0, start_region: str = "seen") -> Task:
    """Drive to a place and stand there.

    Args:
        robot: a car.
        goal: x and y, m.
        yaw: heading to stand with, rad.
        start_region: a key of :data:`START_REGIONS`.

    Raises:
        ShapeError: when the robot has no heading, or the goal is not two numbers.
        UnknownNameError: when there is no such start region.
    """
    require(robot, "heading", "park")
    x, y = require_numbers("park", "goal", goal, 2)
    low, high = START_REGIONS[start_region]
    parked = car_at_rest(x, y, yaw)

    def reference(time: Tensor) -> Tensor:
        return time.new_tensor(parked).expand(*time.shape, len(parked))

    def start(rng: np.random.Generator) -> Array:
        return car_at_rest(rng.uniform(low, high), rng.uniform(-START_Y, START_Y), rng.uniform(-START_YAW, START_YAW))

    return Task("park", reference, tracking_cost(robot), start, episode_length(robot))
