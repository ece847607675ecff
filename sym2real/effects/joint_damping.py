"""A joint is braked in proportion to its rate: τ = -d q̇."""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.joint_push import ALONE, INERTIA, braked, inertia
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import damping_quantity, rate_column

# Decay of a rate in one period: an Euler step swings up beyond 2, a Runge–Kutta step beyond 2.8, of which the
# description may take a half (``robots/runge_kutta.py``).
IN_A_PERIOD = 1.4


def _parameters(body: Body) -> tuple[Parameter, ...]:
    unit = "N m s" if body.unit == "rad" else "N s/m"
    # One that brakes in 3 s; at most in a tenth of one, or as fast as equations in periods can follow, beside as much
    # again as brakes the joint by its description.
    scale, described = inertia(body) / 3.0, body.numbers.get(f"{body.column}_braking", 0.0)
    fast = IN_A_PERIOD * body.numbers.get(ALONE.format(column=body.column), inertia(body)) / body.dt
    return (Parameter("value", unit, null=0.0, low=0.0, high=max(30 * scale, fast) + described, scale=scale),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    joint, damping = body.column, values["value"]
    return braked(equations, body, damping_quantity(joint), damping, -damping * symbol(rate_column(joint)))


def _brake(spec: Any, body: Body, values: Numbers) -> None:
    """The damping that MuJoCo's joints have."""
    joint = spec.joint(body.column)
    joint.damping[0] += values["value"]  # of a polynomial in the rate


JOINT_DAMPING = Kind(
    name="joint_damping",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = -d\,\dot q",
    summary="A joint is braked in proportion to its rate.",
    confused_with="dry friction at one speed; an actuator that loses force with speed",
    shown_by="slow and fast motion of the joint, both ways",
    fix="put the damping into the model; a thinner lubricant or a free bearing lowers it",
    inject=editing(_brake),
    substitute=_substitute,
    needs=(rate_column("{column}"),),
    numbers=(INERTIA,),
    robot="robot with joints",
    columns="joint",
)
