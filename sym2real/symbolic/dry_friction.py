"""Dry (Coulomb) friction as an expression that holds what stands."""

from sympy import Expr, Integer, Max, Min, sqrt

USUAL_DECELERATION = 0.3  # m/s², rad/s²: what dry friction takes of a rate, about
NOTHING, MOST = Integer(0), Integer(1)
SMALL = 1e-6


def dry_friction(
    friction: Expr, rate: Expr, dt: float, inertia: Expr | float, other: Expr = NOTHING
) -> tuple[Expr, Expr]:
    """Mean force or torque over ``dt`` s against a rate in m/s or rad/s, and what its early part moves more.

    Exact for what has this ``inertia`` in kg or kg m² and constant ``other`` forces: friction brakes until there is no
    rate; from there on it holds what is less than itself, or brakes what goes back. So from a rate v forwards, its mean
    F̄ is -F, or what takes all of v, or F (1 - 2 t/dt) where what else acts turns v round at t = m v / (F - other) < dt.
    The second is what the place is off by then, times the inertia, if F̄ acts all the time: -(F + F̄) t dt / 2.

    Of no friction at all there is a derivative, because a usual one is added to what the force is held against.
    """
    limit, momentum = sqrt((USUAL_DECELERATION * inertia) ** 2 + friction**2), inertia / dt * rate

    def part(way: int) -> Expr:
        against = Max(limit - way * other, SMALL * limit, evaluate=False)
        return Min(Max(way * momentum, NOTHING, evaluate=False) / against, MOST, evaluate=False)

    # Unevaluated: SymPy would look long, and in vain, for which is the greater.
    held = Min(-(momentum + other) / limit, 1 - 2 * part(1), evaluate=False)
    mean = friction * Max(held, 2 * part(-1) - 1, evaluate=False)
    return mean, dt**2 / 2 * ((friction - mean) * part(-1) - (friction + mean) * part(1))
