"""Dry (Coulomb) friction as a smooth expression."""

from __future__ import annotations

from sympy import Expr, sqrt, tanh

USUAL_DECELERATION = 0.3  # m/s², rad/s²: what dry friction takes of a rate, about


def dry_friction(friction: Expr, rate: Expr, dt: float, inertia: float) -> Expr:
    """Force or torque against a rate in m/s or rad/s: -friction sign(rate).

    Within half of the rate that it, or a usual friction, takes away in one period of ``dt`` s from what it brakes, of
    this ``inertia`` in kg or kg m², it holds rather than slides. Much steeper, Runge-Kutta steps would swing about
    rest: they are stable up to 2.8 times the decay in a period.
    """
    deceleration = sqrt(USUAL_DECELERATION**2 + (friction / inertia) ** 2)
    return -friction * tanh(rate / (0.5 * dt * deceleration))
