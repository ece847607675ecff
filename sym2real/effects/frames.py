"""Axes and velocities as expressions over the columns of a body."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Integer, sqrt

from sym2real.effects.body import Body
from sym2real.symbolic import symbol

QUATERNION = ("qw", "qx", "qy", "qz")
HEADING = ("sin_yaw", "cos_yaw")
Axes = tuple[tuple[Expr, ...], ...]


def velocity(body: Body) -> tuple[Expr, ...]:
    """Velocity of the body frame's origin in world axes, m/s: two components in a plane."""
    return tuple(symbol(name) for name in ("vx", "vy", "vz")[: 2 if body.planar else 3])


def axes(body: Body) -> Axes:
    """The body's axes in world axes: two in a plane, three else."""
    if body.planar:
        sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
        return ((cosine, sine), (-sine, cosine))
    w, x, y, z = (symbol(name) for name in QUATERNION)
    return (
        (1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x**2 + z**2), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x**2 + y**2)),
    )


def body_velocity(body: Body) -> tuple[Expr, ...]:
    """Velocity along the body's axes, m/s."""
    return tuple(dot(axis, velocity(body)) for axis in axes(body))


def to_world(body: Body, along: Sequence[Expr]) -> tuple[Expr, ...]:
    """A vector of components along the body's axes, in world axes."""
    return tuple(dot(along, column) for column in zip(*axes(body), strict=True))


def dot(left: Sequence[Expr], right: Sequence[Expr]) -> Expr:
    """Scalar product."""
    return sum((a * b for a, b in zip(left, right, strict=True)), start=Integer(0))


def norm(vector: Sequence[Expr]) -> Expr:
    """Length of a vector."""
    return sqrt(dot(vector, vector))
