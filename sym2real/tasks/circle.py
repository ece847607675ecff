"""A circle around the origin: (r cos ωt, r sin ωt), ω = v / r."""

import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.tasks.path import Path, following
from sym2real.tasks.task import Task, motion, require, require_positive

RADIUS = {"flight": 0.5, "drive": 1.5}  # m; the car's from the paper authors' logs
SPEED = {"flight": 1.0, "drive": 0.825}  # m/s; the car's from the paper authors' logs


def circle(robot: Robot, radius: float | None = None, speed: float | None = None, clockwise: bool = False) -> Task:
    """Follow a circle.

    Args:
        robot: the robot.
        radius: m; 0.5 for a quadrotor, 1.5 for a car.
        speed: m/s; 1.0 for a quadrotor, 0.825 for a car.
        clockwise: seen from above.

    Raises:
        ShapeError: for a radius or a speed that is not positive.
    """
    return following("circle", circular_path(robot, radius, speed, clockwise), robot)


def reverse_circle(
    robot: Robot, radius: float | None = None, speed: float | None = None, clockwise: bool = False
) -> Task:
    """Follow the circle with the car pointing against its velocity.

    Args:
        robot: a car.
        radius: m.
        speed: m/s along the path, positive.
        clockwise: seen from above.

    Raises:
        ShapeError: when the robot has no heading, and for a radius or a speed that is not positive.
    """
    require(robot, "heading", "reverse_circle")
    return following("reverse_circle", circular_path(robot, radius, speed, clockwise), robot, reverse=True)


def circular_path(robot: Robot, radius: float | None, speed: float | None, clockwise: bool) -> Path:
    """The circle as a path, with the robot's defaults where nothing is given.

    Raises:
        ShapeError: for a radius or a speed that is not positive.
    """
    kind = motion(robot)
    r = RADIUS[kind] if radius is None else radius
    pace = SPEED[kind] if speed is None else speed
    require_positive("circle", radius=r, speed=pace)
    omega = pace / r * (-1.0 if clockwise else 1.0)

    def path(time: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        cosine, sine = torch.cos(omega * time), torch.sin(omega * time)
        outward = torch.stack([cosine, sine], dim=-1)
        forward = torch.stack([-sine, cosine], dim=-1)
        return r * outward, r * omega * forward, -r * omega**2 * outward

    return path
