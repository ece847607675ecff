"""From a path in the plane to the full state that a robot should have on it, and the task of following it.

A path maps time in s ``# (...,)`` to position, velocity and acceleration ``# (..., 2)`` each, in m, m/s, m/s².
A quadrotor keeps level with yaw 0 at a height; a car points along the path, or against it in reverse.
"""

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.task import Reference, Task, flies
from sym2real.trajectory import Array

Path = Callable[[Tensor], tuple[Tensor, Tensor, Tensor]]

HEIGHT = 1.0  # m, where the quadrotor's tasks are flown
FLIGHT = 8.0  # s, 400 steps of 0.02 s
DRIVE = 15.0  # s, 300 steps of 0.05 s
# A car is put down by hand: within 0.1 m and 10° of the path.
SPREAD = 0.1
TURN = float(np.deg2rad(10.0))


def following(name: str, path: Path, robot: Robot, reverse: bool = False) -> Task:
    """The task of following a path, from rest at its first point: a quadrotor level on it, a car near it.

    Args:
        name: of the task.
        path: the path in the plane.
        robot: that follows it.
        reverse: a car points against its velocity.
    """
    reference = along(path, robot, reverse)
    first = at_rest(reference, robot)

    def start(rng: np.random.Generator) -> Array:
        if flies(robot):
            return first.copy()
        x, y = first[:2] + rng.uniform(-SPREAD, SPREAD, 2)
        return car_at_rest(x, y, float(np.arctan2(first[2], first[3])) + rng.uniform(-TURN, TURN))

    return Task(name, reference, tracking_cost(robot), start, episode_length(robot))


def car_at_rest(x: float, y: float, yaw: float) -> Array:
    """State ``# (7,)`` of a car that stands at a place in m with a heading in rad."""
    return np.array([x, y, np.sin(yaw), np.cos(yaw), 0.0, 0.0, 0.0])


def episode_length(robot: Robot) -> float:
    """Length of an episode in s."""
    return FLIGHT if flies(robot) else DRIVE


def along(path: Path, robot: Robot, reverse: bool = False, height: float = HEIGHT) -> Reference:
    """Reference state of a robot that follows a path.

    Args:
        path: the path in the plane.
        robot: gives the state columns.
        reverse: a car points against its velocity.
        height: of a quadrotor's flight, m.
    """

    def fly(time: Tensor) -> Tensor:
        position, velocity, _ = path(time)
        z = torch.full_like(position[..., :1], height)
        zero = torch.zeros_like(z)
        return torch.cat([position, z, torch.ones_like(z), zero, zero, zero, velocity] + [zero] * 4, dim=-1)

    def drive(time: Tensor) -> Tensor:
        position, velocity, acceleration = path(time)
        squared = velocity.square().sum(-1, keepdim=True)
        direction = velocity / squared.sqrt() * (-1.0 if reverse else 1.0)
        turn = velocity[..., :1] * acceleration[..., 1:] - velocity[..., 1:] * acceleration[..., :1]
        return torch.cat([position, direction.flip(-1), velocity, turn / squared], dim=-1)

    return fly if flies(robot) else drive


def at_rest(reference: Reference, robot: Robot) -> Array:
    """The reference's first state with its velocities set to zero ``# (state,)``."""
    state: Array = reference(torch.zeros((), dtype=torch.float64)).numpy().copy()
    for field in ("velocity", "rate"):
        state[robot.layouts.state.slice(field)] = 0.0
    return state
