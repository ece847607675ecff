"""Unit quaternions in torch: order w x y z, rotating body vectors into the world.

Every function takes any leading batch dimensions, features last. Products of large batches keep every component in one
piece of memory, because all that is done with them works on one component at a time.
Formulas: J. Solà, "Quaternion kinematics for the error-state Kalman filter" (arXiv:1711.02508), Hamilton convention.
"""

from collections.abc import Iterable
from typing import Any

import torch
from torch import Tensor

SMALL = 1e-12


def product(left: Iterable[Any], right: Iterable[Any]) -> tuple[Any, Any, Any, Any]:
    """Components of the Hamilton product left ⊗ right, of what can be multiplied and added: tensors, expressions."""
    w1, x1, y1, z1 = left
    w2, x2, y2, z2 = right
    return (
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    )


def axes(quaternion: Iterable[Any]) -> tuple[tuple[Any, Any, Any], ...]:
    """The body's axes x, y and z, each in world axes, of components w x y z of unit length: numbers, expressions."""
    w, x, y, z = quaternion
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
    )


def multiply(left: Tensor, right: Tensor) -> Tensor:
    """Hamilton product left ⊗ right of quaternions ``# (..., 4)``."""
    return torch.stack(product(left.unbind(-1), right.unbind(-1))).movedim(0, -1)


def conjugate(quaternion: Tensor) -> Tensor:
    """Inverse rotation of a unit quaternion ``# (..., 4)``."""
    return torch.cat([quaternion[..., :1], -quaternion[..., 1:]], dim=-1)


def normalise(quaternion: Tensor) -> Tensor:
    """Nearest unit quaternion ``# (..., 4)``."""
    unit: Tensor = quaternion / quaternion.norm(dim=-1, keepdim=True).clamp_min(SMALL)
    return unit


def rotate(quaternion: Tensor, vector: Tensor) -> Tensor:
    """Body vector ``# (..., 3)`` in world axes."""
    scalar, axis = quaternion[..., :1], quaternion[..., 1:]
    axis, vector = torch.broadcast_tensors(axis, vector)
    twice = 2.0 * torch.linalg.cross(axis, vector)
    turned: Tensor = vector + scalar * twice + torch.linalg.cross(axis, twice)
    return turned


def to_matrix(quaternion: Tensor) -> Tensor:
    """Rotation matrix ``# (..., 3, 3)``, columns are the body axes in the world."""
    columns = [rotate(quaternion, axis) for axis in torch.eye(3, dtype=quaternion.dtype, device=quaternion.device)]
    return torch.stack(columns, dim=-1)


def exponential(vector: Tensor) -> Tensor:
    """Unit quaternion ``# (..., 4)`` of a rotation vector in rad ``# (..., 3)``."""
    half = 0.5 * vector
    angle = half.square().sum(-1, keepdim=True).clamp_min(SMALL**2).sqrt()
    return torch.cat([angle.cos(), half * (angle.sin() / angle)], dim=-1)


def logarithm(quaternion: Tensor) -> Tensor:
    """Shortest rotation vector in rad ``# (..., 3)`` of a unit quaternion ``# (..., 4)``."""
    short = torch.where(quaternion[..., :1] < 0, -quaternion, quaternion)
    sine = short[..., 1:].square().sum(-1, keepdim=True).clamp_min(SMALL**2).sqrt()
    return short[..., 1:] * (2.0 * torch.atan2(sine, short[..., :1]) / sine)


def from_euler(roll: Tensor, pitch: Tensor, yaw: Tensor) -> Tensor:
    """Quaternion ``# (..., 4)`` of yaw about z, then pitch about the new y, then roll about the new x, in rad."""
    zero = torch.zeros_like(roll)
    about_x = exponential(torch.stack([roll, zero, zero], -1))
    about_y = exponential(torch.stack([zero, pitch, zero], -1))
    about_z = exponential(torch.stack([zero, zero, yaw], -1))
    return multiply(about_z, multiply(about_y, about_x))


def to_euler(quaternion: Tensor) -> Tensor:
    """Roll, pitch and yaw of :func:`from_euler` in rad ``# (..., 3)``; at pitch ± 90° roll and yaw are not unique."""
    w, x, y, z = quaternion.unbind(-1)
    roll = torch.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = torch.asin((2.0 * (w * y - x * z)).clamp(-1.0, 1.0))
    return torch.stack([roll, pitch, yaw(quaternion)], dim=-1)


def yaw(quaternion: Tensor) -> Tensor:
    """Heading of the body x axis in the world's x-y plane, rad ``# (...)``."""
    w, x, y, z = quaternion.unbind(-1)
    return torch.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def tilt(quaternion: Tensor) -> Tensor:
    """Angle between the body z axis and the world's vertical, rad ``# (...)``."""
    _, x, y, _ = quaternion.unbind(-1)
    return 2.0 * torch.asin((x * x + y * y).sqrt().clamp(max=1.0))
