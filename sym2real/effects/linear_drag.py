"""Drag in proportion to speed, along body axes: F = -c∘v."""

from typing import Any

from sym2real.effects import truth
from sym2real.effects.alike import ONE_DRAG, Member
from sym2real.effects.body import Body
from sym2real.effects.frames import body_velocity, to_world, velocity
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations


def _parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    names = ("cx", "cy", "cz")[: len(velocity(body))]
    return tuple(Parameter(name, "N s/m", null=0.0, low=0.0, high=5 * mass, scale=0.3 * mass) for name in names)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    coefficients = list(values.values())
    if all(value == coefficients[0] for value in coefficients):
        return push(equations, body, force=[-coefficients[0] * speed for speed in velocity(body)])
    along = [-value * speed for value, speed in zip(coefficients, body_velocity(body), strict=True)]
    return push(equations, body, force=to_world(body, along))


def _drag(data: Any, body: Body, values: Numbers) -> None:
    coefficients, turned = [values.get(name, 0.0) for name in ("cx", "cy", "cz")], truth.rotation(data)
    truth.add_force(data, -turned @ (coefficients * (turned.T @ truth.velocity(data))))


LINEAR_DRAG = Kind(
    name="linear_drag",
    stage="wrench",
    parameters=_parameters,
    formula=r"F = -c \circ v \;\text{(body)}",
    summary="Air or rotors brake in proportion to speed.",
    confused_with="quadratic drag in hover or at one speed; wind on one straight flight",
    shown_by="several speeds between 0.5 and 1.6 m/s, in both directions",
    fix="put the drag into the model; a smaller frame or guards off lower it",
    inject=truth.pushing(_drag),
    of_joints="joint_damping",
    substitute=_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    alike=(Member(ONE_DRAG, 0),),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
