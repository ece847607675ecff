"""Axes and velocities as expressions over the columns of a body."""

from collections.abc import Sequence

from sympy import Expr, Integer, sqrt

from sym2real import rotation, vocabulary
from sym2real.effects.body import Body
from sym2real.symbolic import symbol

QUATERNION, HEADING = vocabulary.ATTITUDE.columns, vocabulary.HEADING.columns
Axes = tuple[tuple[Expr, ...], ...]


def velocity(body: Body) -> tuple[Expr, ...]:
    """Velocity of the body frame's origin in world axes, m/s: two components in a plane."""
    return tuple(symbol(name) for name in vocabulary.VELOCITY.columns[: 2 if body.planar else 3])


def axes(body: Body) -> Axes:
    """The body's axes in world axes: two in a plane, three else."""
    if body.planar:
        sine, cosine = symbol("sin_yaw"), symbol("cos_yaw")
        return ((cosine, sine), (-sine, cosine))
    return rotation.axes([symbol(name) for name in QUATERNION])


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
