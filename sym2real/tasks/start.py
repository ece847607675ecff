"""Where episodes start."""

from collections.abc import Callable

import numpy as np

from sym2real.robots.robot import Robot
from sym2real.tasks.path import at_rest
from sym2real.tasks.task import Reference, flies
from sym2real.trajectory import Array

Start = Callable[[np.random.Generator], Array]

# A car is put down by hand: within 0.1 m and 10° of the path.
SPREAD = 0.1
TURN = float(np.deg2rad(10.0))


def on_path(reference: Reference, robot: Robot) -> Start:
    """Start at rest at the path's first point: a quadrotor level on it, a car near it."""
    first = at_rest(reference, robot)
    if flies(robot):
        return lambda rng: first.copy()
    yaw = float(np.arctan2(first[2], first[3]))

    def start(rng: np.random.Generator) -> Array:
        x, y = first[:2] + rng.uniform(-SPREAD, SPREAD, 2)
        return car_at_rest(x, y, yaw + rng.uniform(-TURN, TURN))

    return start


def car_at_rest(x: float, y: float, yaw: float) -> Array:
    """State ``# (7,)`` of a car that stands at a place in m with a heading in rad."""
    return np.array([x, y, np.sin(yaw), np.cos(yaw), 0.0, 0.0, 0.0])
