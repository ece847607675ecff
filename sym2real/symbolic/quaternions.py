"""Quaternions of unit length as expressions: w x y z, from the body's axes to the world's."""

from collections.abc import Sequence

from sympy import Expr


def body_axes(quaternion: Sequence[Expr]) -> tuple[tuple[Expr, ...], ...]:
    """The body's axes x, y and z, each in world axes."""
    w, x, y, z = quaternion
    return (
        (1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x**2 + z**2), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x**2 + y**2)),
    )
