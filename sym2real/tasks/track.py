"""A closed track of straights and arcs at constant speed: a polygon with rounded corners.

At arc length d into a piece that starts at p₀ with heading θ₀ and curvature κ::

    p = p₀ + d sinc(κd/2) (cos(θ₀ + κd/2), sin(θ₀ + κd/2)),   θ = θ₀ + κd
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.registry import Registry
from sym2real.robots.robot import Robot
from sym2real.tasks.path import Path, following
from sym2real.tasks.task import Task, motion, require_positive
from sym2real.trajectory import Array


@dataclass(frozen=True)
class Polygon:
    """Corners in driving order, m ``# (corners, 2)``, each rounded with the same radius in m."""

    corners: tuple[tuple[float, float], ...]
    radius: float


# The car turns no tighter than about 0.75 m. "hook" has a right turn that "oval" never shows.
TRACKS = Registry(
    "track",
    {
        "oval": Polygon(((-2.0, -1.2), (2.0, -1.2), (2.0, 1.2), (-2.0, 1.2)), 1.1),
        "hook": Polygon(((-2.2, -2.2), (2.2, -2.2), (2.2, 0.0), (0.0, 0.0), (0.0, 2.2), (-2.2, 2.2)), 0.95),
    },
)
SCALE = {"flight": 0.4, "drive": 1.0}
SPEED = 0.6  # m/s: four times as fast, the paper's unseen track is just within the car's limit


def track(robot: Robot, shape: str = "oval", speed: float = SPEED, scale: float | None = None) -> Task:
    """Follow a closed track.

    Args:
        robot: the robot.
        shape: a key of :data:`TRACKS`.
        speed: m/s.
        scale: enlarges the track; 0.4 for a quadrotor, 1 for a car.

    Raises:
        UnknownNameError: when there is no such track.
        ShapeError: for a speed or a scale that is not positive.
    """
    size = SCALE[motion(robot)] if scale is None else scale
    require_positive("track", speed=speed, scale=size)
    return following("track", rounded_path(TRACKS[shape], speed, size), robot)


def rounded_path(polygon: Polygon, speed: float, scale: float) -> Path:
    """The rounded polygon as a path that starts where its first corner ends."""
    pieces = torch.from_numpy(pieces_of(polygon, scale))
    ends = pieces[:, 4].cumsum(0)

    def path(time: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        length = torch.remainder(speed * time.to(torch.float64), ends[-1].item())
        index = torch.searchsorted(ends.to(time.device), length, right=True).clamp(max=len(ends) - 1)
        x, y, heading, curvature, _ = pieces.to(time.device)[index].unbind(-1)
        distance = length - (ends - pieces[:, 4]).to(time.device)[index]
        chord = distance * torch.sinc(curvature * distance / (2 * torch.pi))
        middle, angle = heading + curvature * distance / 2, heading + curvature * distance
        forward = torch.stack([angle.cos(), angle.sin()], dim=-1)
        left = torch.stack([-angle.sin(), angle.cos()], dim=-1)
        position = torch.stack([x + chord * middle.cos(), y + chord * middle.sin()], dim=-1)
        acceleration = speed**2 * curvature[..., None] * left
        return position.to(time.dtype), (speed * forward).to(time.dtype), acceleration.to(time.dtype)

    return path


def pieces_of(polygon: Polygon, scale: float) -> Array:
    """Straights and arcs ``# (pieces, 5)``: x and y in m, heading in rad, curvature in 1/m, length in m."""
    corners, radius = scale * np.array(polygon.corners), scale * polygon.radius
    edges = np.roll(corners, -1, axis=0) - corners
    headings = np.arctan2(edges[:, 1], edges[:, 0])
    turns = np.remainder(headings - np.roll(headings, 1) + np.pi, 2 * np.pi) - np.pi
    cut = radius * np.abs(np.tan(turns / 2))  # what rounding takes from the edges on both sides of a corner
    pieces = []
    for i, (corner, edge, heading) in enumerate(zip(corners, edges, headings, strict=True)):
        after = (i + 1) % len(corners)
        forward = np.array([np.cos(heading), np.sin(heading)])
        straight = float(np.linalg.norm(edge)) - cut[i] - cut[after]
        pieces.append([*(corner + cut[i] * forward), heading, 0.0, straight])
        arc = [heading, float(np.sign(turns[after])) / radius, radius * abs(turns[after])]
        pieces.append([*(corners[after] - cut[after] * forward), *arc])
    return np.array(pieces)
