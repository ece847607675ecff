"""A figure of eight around the origin: the lemniscate of Bernoulli, with s = sin θ, c = cos θ, D = 1 + s²::

    p = a (c, s c) / D,   dp/dθ = a (-s (3 - s²), 1 - 3 s²) / D²,   d²p/dθ² = a c (12 s² - 3 - s⁴, s (6 s² - 10)) / D³

Its curvature is at most 3/a and its speed within a factor of √2.
"""

from math import pi

import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.tasks.path import following
from sym2real.tasks.task import Task, motion, require_positive

HALF_WIDTH = {"flight": 0.5, "drive": 2.4}  # m; the car's is the smallest that its steering allows with some reserve
PERIOD = {"flight": 4.0, "drive": 15.0}  # s


def lemniscate(robot: Robot, half_width: float | None = None, period: float | None = None) -> Task:
    """Follow a figure of eight.

    Args:
        robot: the robot.
        half_width: a, m; 0.5 for a quadrotor, 2.4 for a car.
        period: of one whole eight, s; 4 for a quadrotor (at most 0.8 m/s), 15 for a car (at most 1 m/s).

    Raises:
        ShapeError: for a half width or a period that is not positive.
    """
    kind = motion(robot)
    a = HALF_WIDTH[kind] if half_width is None else half_width
    lap = PERIOD[kind] if period is None else period
    require_positive("lemniscate", half_width=a, period=lap)
    omega = 2 * pi / lap

    def path(time: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        angle = omega * time - pi / 2  # from the crossing
        s, c = torch.sin(angle), torch.cos(angle)
        d = 1 + s**2
        position = a * torch.stack([c / d, s * c / d], dim=-1)
        velocity = a * omega * torch.stack([-s * (3 - s**2), 1 - 3 * s**2], dim=-1) / d[..., None] ** 2
        bend = torch.stack([c * (12 * s**2 - 3 - s**4), s * c * (6 * s**2 - 10)], dim=-1)
        return position, velocity, a * omega**2 * bend / d[..., None] ** 3

    return following("lemniscate", path, robot)
