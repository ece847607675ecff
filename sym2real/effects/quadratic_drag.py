"""Drag in proportion to the square of speed: F = -c‖v‖v."""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.alike import ONE_DRAG, Member
from sym2real.effects.body import Body
from sym2real.effects.frames import norm, velocity
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations


def _parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    return (Parameter("value", "N s²/m²", null=0.0, low=0.0, high=5 * mass, scale=0.3 * mass),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    speed = norm(velocity(body))
    return push(equations, body, force=[-values["value"] * speed * component for component in velocity(body)])


def _drag(data: Any, body: Body, values: Numbers) -> None:
    moving = truth.velocity(data)
    if body.planar:
        moving[2] = 0.0
    truth.add_force(data, -values["value"] * float(np.linalg.norm(moving)) * moving)


QUADRATIC_DRAG = Kind(
    name="quadratic_drag",
    stage="wrench",
    parameters=_parameters,
    formula=r"F = -c\,\|v\|\,v",
    summary="Air brakes in proportion to the square of speed.",
    confused_with="linear drag in hover or at one speed",
    shown_by="several speeds between 0.5 and 1.6 m/s",
    fix="put the drag into the model; less frontal area lowers it",
    inject=truth.pushing(_drag),
    substitute=_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    alike=(Member(ONE_DRAG, 1),),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
