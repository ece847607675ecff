"""Paths of the standard set: hover, circles and figures of eight whose speed, height and heading vary on purpose.

Variation is what tells effects apart: heights swing for what depends on height, speeds for what depends on speed, both
directions of turning for what steering leaves open, and a turning heading for what stays with the body.
A figure of eight is (a cos φ, 0.315 a sin 2φ), the flattest curve at its sharpest places: curvature at most 2.52/a.
A car drives it at its speed along the path; a quadrotor flies it at an even φ' and has its speed at the crossing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np
import torch
from torch import Tensor

from sym2real.robots.robot import Robot
from sym2real.rotation import exponential
from sym2real.tasks.task import Reference, flies
from sym2real.trajectory import Array

SWING_PERIOD = 4.0  # s, of the height
MODULATION_PERIOD = 5.0  # s, of a car's speed
LOBE = 0.315  # 32^(-1/3): half height of a figure of eight over its half width
POINTS = 4096  # of a table of the path's length
HALF_STEP = 1e-3  # s, for the turning rate of a car's path


@dataclass(frozen=True)
class Manoeuvre:
    """One row of the table.

    Args:
        shape: what is flown or driven.
        size: radius or half width in m.
        speed: along the path in m/s.
        height: in m.
        swing: amplitude of the height in m.
        modulation: amplitude of the speed as a part of it.
        clockwise: direction of a circle, from above.
    """

    shape: str
    size: float = 1.0
    speed: float = 0.0
    height: float = 0.0
    swing: float = 0.0
    modulation: float = 0.0
    clockwise: bool = False


def path_of(robot: Robot, manoeuvre: Manoeuvre, phase: float, yaw_rate: float = 0.0) -> Reference:
    """States ``# (..., state)`` of a robot on the path: :func:`flight`, or :func:`drive` without a yaw rate."""
    return flight(manoeuvre, phase, yaw_rate) if flies(robot) else drive(manoeuvre, phase)


def flight(manoeuvre: Manoeuvre, phase: float, yaw_rate: float = 0.0) -> Reference:
    """States ``# (..., 13)`` of a quadrotor on the path, level.

    Args:
        manoeuvre: the path.
        phase: where it starts on the path and in the swing, rad.
        yaw_rate: of the heading in rad/s.
    """
    path = _along(manoeuvre, phase, even=True)
    omega = 2 * pi / SWING_PERIOD

    def reference(time: Tensor) -> Tensor:
        position, velocity = path(time)
        zero = torch.zeros_like(time)
        height = manoeuvre.height + manoeuvre.swing * torch.sin(omega * time + phase)
        climb = omega * manoeuvre.swing * torch.cos(omega * time + phase)
        attitude = exponential(torch.stack([zero, zero, yaw_rate * time], -1))
        rate = torch.stack([zero, zero, zero + yaw_rate], -1)
        return torch.cat([position, height[..., None], attitude, velocity, climb[..., None], rate], -1)

    return reference


def drive(manoeuvre: Manoeuvre, phase: float) -> Reference:
    """States ``# (..., 7)`` of a car on the path, pointing along it; arguments as of :func:`flight`."""
    path = _along(manoeuvre, phase, even=False)

    def reference(time: Tensor) -> Tensor:
        positions, velocities = path(torch.stack([time, time + HALF_STEP, time - HALF_STEP]))
        yaw, after, before = torch.atan2(velocities[..., 1], velocities[..., 0])
        position, velocity, turned = positions[0], velocities[0], after - before
        rate = torch.atan2(torch.sin(turned), torch.cos(turned)) / (2 * HALF_STEP)
        return torch.cat([position, torch.stack([torch.sin(yaw), torch.cos(yaw)], -1), velocity, rate[..., None]], -1)

    return reference


def _along(manoeuvre: Manoeuvre, phase: float, even: bool) -> Callable[[Tensor], tuple[Tensor, Tensor]]:
    """Position and velocity ``# (..., 2)`` in the plane at times in s ``# (...,)``."""
    if manoeuvre.shape == "hover":
        return lambda time: (torch.stack([time * 0, time * 0], -1),) * 2
    angles, lengths, largest = _table(manoeuvre.shape)
    if even:
        lengths = angles * largest
    begin = float(np.interp(phase % (2 * pi), angles, lengths))
    direction = -1.0 if manoeuvre.clockwise else 1.0
    omega, part = 2 * pi / MODULATION_PERIOD, manoeuvre.modulation

    def path(time: Tensor) -> tuple[Tensor, Tensor]:
        driven = manoeuvre.speed * (time + part * torch.sin(omega * time) / omega)
        speed = direction * manoeuvre.speed * (1 + part * torch.cos(omega * time))[..., None]
        length = (begin + direction * driven / manoeuvre.size) % lengths[-1]
        angle = torch.as_tensor(np.interp(length.numpy(), lengths, angles), dtype=time.dtype)
        place, tangent = _shape(manoeuvre.shape, angle)
        pace = tangent / (largest if even else tangent.norm(dim=-1, keepdim=True))
        return manoeuvre.size * place, speed * pace

    return path


def _shape(shape: str, angle: Tensor) -> tuple[Tensor, Tensor]:
    """Point of the path of size one and its derivative by the angle ``# (..., 2)``."""
    s, c = torch.sin(angle), torch.cos(angle)
    if shape == "circle":
        return torch.stack([c, s], -1), torch.stack([-s, c], -1)
    return torch.stack([c, 2 * LOBE * s * c], -1), torch.stack([-s, 2 * LOBE * (c * c - s * s)], -1)


@lru_cache
def _table(shape: str) -> tuple[Array, Array, float]:
    """Angles, the length of the path of size one up to them ``# (POINTS,)``, and its largest slope."""
    angles = np.linspace(0.0, 2 * pi, POINTS)
    slopes = _shape(shape, torch.from_numpy(angles))[1].norm(dim=-1).numpy()
    steps = 0.5 * (slopes[1:] + slopes[:-1]) * np.diff(angles)
    return angles, np.concatenate([[0.0], np.cumsum(steps)]), float(slopes.max())
