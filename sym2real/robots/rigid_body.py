"""Small rotations and exponential responses as SymPy expressions: the pieces of first-principles equations.

Increments are series in the half angle h = ‖θ‖/2; the terms left out are
h⁵/120, below 1e-7 for 0.1 rad a step.
"""

import math
from collections.abc import Iterable, Sequence

from sympy import Expr, Rational

from sym2real.symbolic import symbol

Vector = tuple[Expr, ...]


def symbols(names: Iterable[str]) -> Vector:
    """The symbols of these names."""
    return tuple(symbol(name) for name in names)


def increment(angle: Sequence[Expr]) -> Vector:
    """Quaternion of a rotation by a small vector ``angle`` in rad."""
    half = [component / 2 for component in angle]
    square = sum(component**2 for component in half)
    sine_over_angle = 1 - square / 6
    return (1 - square / 2 + square**2 / 24, *(sine_over_angle * component for component in half))


def gyroscopic(inertia: Sequence[float], rate: Sequence[Expr]) -> Vector:
    """-J⁻¹ (ω × J ω) for principal axes, rad/s² (Euler's equations)."""
    (jx, jy, jz), (wx, wy, wz) = inertia, rate
    return ((jy - jz) / jx * wy * wz, (jz - jx) / jy * wz * wx, (jx - jy) / jz * wx * wy)


class FirstOrder:
    """ẋ = k (u - x) + α over a time t, with u and α held.

    x(t) = u + (x - u) e^(-kt) + α (1 - e^(-kt)) / k, and its mean over the time; k = ∞ is reached at once.
    """

    def __init__(self, gain: float, time: float) -> None:
        self.kept = math.exp(-gain * time)
        self.mean_kept = (1.0 - self.kept) / (gain * time) if math.isfinite(gain) else 0.0
        self.drift = time * self.mean_kept
        self.mean_drift = (1.0 - self.mean_kept) / gain

    def end(self, start: Expr, command: Expr, drift: Expr) -> Expr:
        """x at the end."""
        return command + self.kept * (start - command) + self.drift * drift

    def mean(self, start: Expr, command: Expr, drift: Expr) -> Expr:
        """Mean of x."""
        return command + self.mean_kept * (start - command) + self.mean_drift * drift


def free_fall(position: Expr, velocity: Expr, acceleration: Expr, dt: float) -> tuple[Expr, Expr]:
    """Position and velocity after ``dt`` at a held acceleration."""
    return position + dt * velocity + Rational(1, 2) * dt**2 * acceleration, velocity + dt * acceleration
