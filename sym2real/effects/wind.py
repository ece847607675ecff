"""A constant force along world axes."""

import numpy as np

from sym2real.effects.alike import ONE_FORCE, ONE_LEAN, Member
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.frames import velocity
from sym2real.effects.kind import Kind, Parameter
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import add_force, pushing
from sym2real.effects.wrench import push


def force_parameters(body: Body) -> tuple[Parameter, ...]:
    """Components of a force in N: two in a plane."""
    scale = 0.1 * GRAVITY * body.numbers.get("mass", 1.0)
    names = ("fx", "fy", "fz")[: len(velocity(body))]
    return tuple(Parameter(name, "N", null=0.0, low=-10 * scale, high=10 * scale, scale=scale) for name in names)


WIND = Kind(
    name="wind",
    stage="wrench",
    parameters=force_parameters,
    formula=r"F = \mathrm{const} \;\text{(world)}",
    summary="A steady force along world axes: wind, a pulling cable.",
    confused_with="a tilted mounting of the sensor while yaw stays; a slope under a car",
    shown_by="yaw that turns at 0.5 to 0.8 rad/s",
    fix="shield the room or fly with the force in the model; where it follows the weather, estimate it in flight",
    inject=pushing(
        lambda data, body, values: add_force(data, np.array([values.get(name, 0.0) for name in ("fx", "fy", "fz")]))
    ),
    substitute=lambda equations, values, body: push(equations, body, force=tuple(values.values())),
    needs=("vx", "vy"),
    numbers=("mass",),
    alike=(Member(ONE_LEAN, 0), Member(ONE_FORCE, 0)),
    # A vertical force is thrust's: mass, its map, its offset.
    searching=Searching(fixed=lambda _body, _values, _logs: ("fz",), shown_in=lambda _: (Shown.YAW,)),
)
