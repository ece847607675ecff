"""Inertia that turns or slides with a joint's motor: M_jj → M_jj + a."""

from math import inf
from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.domain import Domain
from sym2real.effects.joint_push import ALONE, inertia, raised
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.truth import editing
from sym2real.vocabulary import armature_quantity

OVERSTATED = 0.5  # part of it that a description may likely be too large by


def _parameters(body: Body) -> tuple[Parameter, ...]:
    unit, scale = ("kg m²" if body.unit == "rad" else "kg"), 0.1 * inertia(body)
    # A description may overstate what turns with the joint, at most by all that a force along it moves while no other
    # joint is held: with less, the masses of the whole robot, in the pose it stands in, are not positive definite.
    most = body.numbers.get(ALONE.format(column=body.column), inf)
    low = -OVERSTATED * min(most, inertia(body))
    return (Parameter("value", unit, 0.0, low, 1000 * scale, scale, domain=Domain(-most, open=True)),)


def _more(spec: Any, body: Body, values: Numbers) -> None:
    """The armature that MuJoCo's joints have."""
    spec.joint(body.column).armature += values["value"]


ARMATURE = Kind(
    name="armature",
    stage="mass",
    parameters=_parameters,
    formula=r"M_{jj} \to M_{jj} + a",
    summary="The rotor and the gear of a motor add inertia to its joint.",
    confused_with="a weaker actuator, where nothing but the actuator moves the joint; a load",
    shown_by="fast and slow changes of the command, and motion that gravity drives",
    fix="put the rotor's inertia times the squared gear ratio into the model",
    inject=editing(_more),
    substitute=lambda equations, values, body: raised(equations, armature_quantity(body.column), values["value"]),
    needs=(armature_quantity("{column}"),),
    robot="robot with joints",
    columns="joint",
)
