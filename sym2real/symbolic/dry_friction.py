"""Dry (Coulomb) friction as a smooth expression."""

from __future__ import annotations

from sympy import Expr, tanh

USUAL_DECELERATION = 0.3  # m/s², rad/s²: what dry friction takes of a rate, about


def dry_friction(friction: Expr, rate: Expr, dt: float) -> Expr:
    """Force or torque against a rate in m/s or rad/s: -friction sign(rate).

    Within the rate that a usual friction takes away in one period of ``dt`` s it holds rather than slides.
    """
    return -friction * tanh(rate / (USUAL_DECELERATION * dt))
