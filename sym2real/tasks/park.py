"""Park a car at (1, 0) with yaw 0, from starts seen in training or from beyond the goal."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from torch import Tensor

from sym2real.registry import Registry
from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.path import car_at_rest, episode_length
from sym2real.tasks.task import Task, require, require_numbers
from sym2real.trajectory import Array


@dataclass(frozen=True)
class StartRegion:
    """Where a car may stand at the start: ranges of x and y in m, yaw between ± ``yaw`` rad."""

    x: tuple[float, float]
    y: tuple[float, float]
    yaw: float = float(np.deg2rad(45.0))

    def draw(self, rng: np.random.Generator) -> Array:
        """A state ``# (7,)`` at rest, uniform in the region."""
        return car_at_rest(rng.uniform(*self.x), rng.uniform(*self.y), rng.uniform(-self.yaw, self.yaw))


# The paper trains on one region and tests on the other, which asks for driving backwards.
START_REGIONS = Registry(
    "start region",
    {"seen": StartRegion((-1.0, -0.5), (-1.0, 1.0)), "unseen": StartRegion((2.5, 3.0), (-1.0, 1.0))},
)


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
    parked = car_at_rest(x, y, yaw)

    def reference(time: Tensor) -> Tensor:
        return time.new_tensor(parked).expand(*time.shape, len(parked))

    return Task("park", reference, tracking_cost(robot), START_REGIONS[start_region].draw, episode_length(robot))
