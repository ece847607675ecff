"""A lateral force at the centre of mass, c ahead of the rear axle: F = -k·m·v_lat, v_lat = v + c·ω_z."""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.alike import ONE_BRAKE, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, push_turning
from sym2real.effects.frames import body_velocity
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.symbolic import Equations, symbol


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    centre = body.number("centre")
    sideways = body_velocity(body)[1] + centre * symbol("wz")
    return push_turning(equations, body, -values["value"] * body.mass * centre * sideways)


def _brake(data: Any, body: Body, values: Numbers) -> None:
    turned = truth.rotation(data)
    along = turned.T @ truth.velocity(data) + np.cross(truth.rates(data), [body.number("centre"), 0.0, 0.0])
    truth.add_force(data, -values["value"] * body.mass * along[1] * turned[:, 1])


LATERAL_SLIP = Kind(
    name="lateral_slip",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "1/s", null=0.0, low=0.0, high=50.0, scale=5.0)),
    formula=r"F_\mathrm{lateral} = -c\,m\,v_\mathrm{lateral}",
    summary="Something drags against sideways motion of the centre of mass; while the tyres hold, turns cost speed.",
    confused_with="yaw drag while the tyres hold",
    shown_by="turns both ways at several speeds, beside straight driving",
    fix="find what drags (cables, a loose wheel), or keep the term in the model",
    inject=truth.pushing(_brake),
    substitute=_substitute,
    needs=("steer", "wz", *FORWARD),
    numbers=("mass", "wheelbase", "centre"),
    robot="car",
    alike=(Member(ONE_BRAKE, 1),),
    searching=Searching(shown_in=lambda _: (Shown.HARD,)),
)
