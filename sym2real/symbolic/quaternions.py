"""Quaternions of unit length as expressions: w x y z, from the body's axes to the world's."""

from collections.abc import Sequence

from sympy import Expr


def multiply(left: Sequence[Expr], right: Sequence[Expr]) -> tuple[Expr, ...]:
    """Hamilton product."""
    w1, x1, y1, z1 = left
    w2, x2, y2, z2 = right
    return (
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    )


def body_axes(quaternion: Sequence[Expr]) -> tuple[tuple[Expr, ...], ...]:
    """The body's axes x, y and z, each in world axes."""
    w, x, y, z = quaternion
    return (
        (1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x**2 + z**2), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x**2 + y**2)),
    )
