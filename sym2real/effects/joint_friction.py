"""Dry (Coulomb) friction of a joint: τ = -c sign(q̇), and what holds it where it stands."""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.joint_push import INERTIA, braked, inertia, unit_of_push
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.dry_friction import USUAL_DECELERATION, dry_friction
from sym2real.trajectory import Array
from sym2real.vocabulary import friction_quantity, rate_column

# Shares of what the joint's actuators can push. A model that sticks where the robot slides, or slides where it sticks,
# predicts worse than one without friction: from beyond a third of the truth nothing leads there.
STARTS = tuple(0.01 * 1.7**step for step in range(6))


def _parameters(body: Body) -> tuple[Parameter, ...]:
    scale = USUAL_DECELERATION * inertia(body)
    # A gear's may be large beside what a light link weighs, and not beside what drives it.
    most = max(30 * scale, body.numbers.get(f"{body.column}_strength", 0.0))
    return (Parameter("value", unit_of_push(body)[0], null=0.0, low=0.0, high=most, scale=scale),)


def _starts(body: Body, _values: Array) -> tuple[float, ...]:
    """A step from no friction finds a damping."""
    strength = body.numbers.get(f"{body.column}_strength", 0.0)
    return tuple(share * strength for share in STARTS if strength > 0)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    joint, friction = body.column, values["value"]
    force = dry_friction(friction, symbol(rate_column(joint)), equations.dt, inertia(body))
    return braked(equations, body, friction_quantity(joint), friction, force)


def _brake(spec: Any, body: Body, values: Numbers) -> None:
    """MuJoCo's frictionloss, a constraint that can hold a joint still."""
    joint = spec.joint(body.column)
    joint.frictionloss = joint.frictionloss + values["value"]


JOINT_FRICTION = Kind(
    name="joint_friction",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = -c\,\mathrm{sign}(\dot q)",
    summary="A joint is braked by a constant force against its motion.",
    confused_with="damping at one speed; an offset of the actuator while the joint moves one way",
    shown_by="slow and fast motion of the joint, with reversals",
    fix="free the bearing or the gear, or compensate the friction in the actuator's loop",
    inject=editing(_brake),
    substitute=_substitute,
    needs=(rate_column("{column}"),),
    numbers=(INERTIA,),
    robot="robot with joints",
    columns="joint",
    searching=Searching(starts=_starts),
)
