"""Dry (Coulomb) friction as an expression that holds what stands."""

from sympy import Expr, Integer, Max, Min, sqrt

USUAL_DECELERATION = 0.3  # m/s², rad/s²: what dry friction takes of a rate, about
NOTHING = Integer(0)


def dry_friction(friction: Expr, rate: Expr, dt: float, inertia: Expr | float, other: Expr = NOTHING) -> Expr:
    """Force or torque against a rate in m/s or rad/s: -friction sign(rate), and where that stands against the others.

    It is what takes all of the rate within half a period of ``dt`` s from what has this ``inertia`` in kg or kg m², and
    the ``other`` forces with it, up to its limit. Taken faster, Runge-Kutta steps would swing about rest: they are
    stable up to 2.8 times the decay in a period. Of no friction at all there is a derivative, because a usual one is
    added to what the force is held against.
    """
    limit = sqrt((USUAL_DECELERATION * inertia) ** 2 + friction**2)
    # Unevaluated: SymPy would look long, and in vain, for which is the greater.
    held = Min((2 * inertia / dt * rate + other) / limit, Integer(1), evaluate=False)
    return -friction * Max(held, Integer(-1), evaluate=False)
