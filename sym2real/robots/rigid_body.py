"""Small rotations and exponential responses as SymPy expressions: the pieces of first-principles equations.

Vectors are NumPy arrays of expressions. Increments are series in the half angle h = ‖θ‖/2; the terms left out are
h⁵/120, below 1e-7 for 0.1 rad a step.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from sympy import Expr, Rational

from sym2real.symbolic import symbol

Vector = Any


def symbols(names: Iterable[str]) -> Vector:
    """The symbols of these names."""
    return np.array([symbol(name) for name in names], dtype=object)


def increment(angle: Vector) -> Vector:
    """Quaternion of a rotation by a small vector ``angle`` in rad."""
    half = angle / 2
    square = (half**2).sum()
    return np.array([1 - square / 2 + square**2 / 24, *((1 - square / 6) * half)], dtype=object)


def gyroscopic(inertia: Sequence[float], rate: Vector) -> Vector:
    """-J⁻¹ (ω × J ω) for principal axes, rad/s² (Euler's equations)."""
    (jx, jy, jz), (wx, wy, wz) = inertia, rate
    return np.array([(jy - jz) / jx * wy * wz, (jz - jx) / jy * wz * wx, (jx - jy) / jz * wx * wy], dtype=object)


class FirstOrder:
    """ẋ = k (u - x) + α over a time t, with u and α held.

    x(t) = u + (x - u) e^(-kt) + α (1 - e^(-kt)) / k, and its mean over the time; k = ∞ is reached at once.

    Args:
        gain: k in 1/s, of one axis or of several.
        time: t in s.
    """

    def __init__(self, gain: float | Sequence[float], time: float) -> None:
        gains = np.asarray(gain, dtype=object)
        self.kept = np.frompyfunc(math.exp, 1, 1)(-gains * time)
        self.mean_kept = (1.0 - self.kept) / (gains * time)
        self.drift = time * self.mean_kept
        self.mean_drift = (1.0 - self.mean_kept) / gains

    def end(self, start: Expr | Vector, command: Expr | Vector, drift: Expr | Vector) -> Expr | Vector:
        """x at the end."""
        return command + self.kept * (start - command) + self.drift * drift

    def mean(self, start: Expr | Vector, command: Expr | Vector, drift: Expr | Vector) -> Expr | Vector:
        """Mean of x."""
        return command + self.mean_kept * (start - command) + self.mean_drift * drift


def free_fall(position: Expr, velocity: Expr, acceleration: Expr, dt: float) -> tuple[Expr, Expr]:
    """Position and velocity after ``dt`` at a held acceleration."""
    return position + dt * velocity + Rational(1, 2) * dt**2 * acceleration, velocity + dt * acceleration
