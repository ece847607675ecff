"""A spring pulls a joint to its zero: τ = -k q. A cable or a hose, a flexure, a counterbalance."""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.joint_push import ALONE, INERTIA, inertia, push_along
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import rate_column

IN_A_PERIOD = 0.5  # rad of an oscillation that equations in periods of control follow


def _parameters(body: Body) -> tuple[Parameter, ...]:
    unit = "N m/rad" if body.unit == "rad" else "N/m"
    # One by which the joint swings at 1 rad/s; at most as fast as equations in periods can follow.
    lightest = body.numbers.get(ALONE.format(column=body.column), inertia(body))
    most = max(30 * inertia(body), lightest * (IN_A_PERIOD / body.dt) ** 2)
    return (Parameter("value", unit, null=0.0, low=0.0, high=most, scale=inertia(body)),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """A push is held for a period: that of its middle, or what it comes too late by would count as damping -½ dt k."""
    middle = symbol(body.column) + equations.dt / 2 * symbol(rate_column(body.column))
    return push_along(equations, body, -values["value"] * middle)


def _pull(spec: Any, body: Body, values: Numbers) -> None:
    """MuJoCo's stiffness of a joint; beside a spring that rests elsewhere the two rest in between."""
    joint = spec.joint(body.column)
    own, both = joint.stiffness[0], joint.stiffness[0] + values["value"]
    joint.springref *= own / both if both > 0.0 else 1.0
    joint.stiffness[0] = both  # of a polynomial in the deflection


JOINT_STIFFNESS = Kind(
    name="joint_stiffness",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = -k\,q",
    summary="A spring pulls a joint to its zero.",
    confused_with="gravity on a link that hangs, in small motion; a servo's gain",
    shown_by="motion of the joint far to both sides of its zero",
    fix="put the spring into the model; free the cable, or take the counterbalance off",
    inject=editing(_pull),
    substitute=_substitute,
    needs=("{column}", rate_column("{column}")),
    numbers=(INERTIA,),
    robot="robot with joints",
    columns="joint",
)
