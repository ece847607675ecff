"""A figure of eight around the origin: the lemniscate of Gerono (a sin ωt, a sin ωt cos ωt)."""

from __future__ import annotations

from math import pi

import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.tasks.cost import tracking_cost
from sym2real.tasks.path import along, episode_length
from sym2real.tasks.start import on_path
from sym2real.tasks.task import Task, flies

HALF_WIDTH = {"flight": 0.5, "drive": 2.0}  # m
PERIOD = {"flight": 5.0, "drive": 15.0}  # s


def lemniscate(robot: Robot, half_width: float | None = None, period: float | None = None) -> Task:
    """Follow a figure of eight.

    Args:
        robot: the robot.
        half_width: a, m; 0.5 for a quadrotor, 2 for a car.
        period: of one whole eight, s; 5 for a quadrotor (at most 0.9 m/s), 15 for a car (at most 1.2 m/s).
    """
    kind = "flight" if flies(robot) else "drive"
    a = HALF_WIDTH[kind] if half_width is None else half_width
    omega = 2 * pi / (PERIOD[kind] if period is None else period)

    def path(time: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        once, twice = omega * time, 2 * omega * time
        position = a * torch.stack([torch.sin(once), torch.sin(twice) / 2], dim=-1)
        velocity = a * omega * torch.stack([torch.cos(once), torch.cos(twice)], dim=-1)
        acceleration = -a * omega**2 * torch.stack([torch.sin(once), 2 * torch.sin(twice)], dim=-1)
        return position, velocity, acceleration

    reference = along(path, robot)
    return Task("lemniscate", reference, tracking_cost(robot), on_path(reference, robot), episode_length(robot))
