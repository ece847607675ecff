"""A torque against turning: τ_z = -c·J·ω_z, J the yaw inertia about the rear axle."""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.alike import ONE_BRAKE, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, push_turning
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.symbolic import Equations, symbol


def _inertia(body: Body) -> float:
    return body.number("jz") + body.mass * body.number("centre") ** 2


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return push_turning(equations, body, -values["value"] * _inertia(body) * symbol("wz"))


def _brake(data: Any, body: Body, values: Numbers) -> None:
    truth.add_torque(data, np.array([0.0, 0.0, -values["value"] * _inertia(body) * truth.rates(data)[2]]))


YAW_DRAG = Kind(
    name="yaw_drag",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "1/s", null=0.0, low=0.0, high=50.0, scale=4.0)),
    formula=r"\tau_z = -c\,J\,\omega_z",
    summary="The car resists turning (scrubbing tyres); while the tyres hold, turns cost speed.",
    confused_with="lateral slip while the tyres hold; a steering gain or offset on one circle",
    shown_by="turns both ways at several speeds, beside straight driving",
    fix="free the differential or the steering's geometry, or keep the term in the model",
    inject=truth.pushing(_brake),
    substitute=_substitute,
    needs=("steer", "wz", *FORWARD),
    numbers=("mass", "wheelbase", "jz", "centre"),
    robot="car",
    alike=(Member(ONE_BRAKE, 0),),
    searching=Searching(shown_in=lambda _: (Shown.HARD,)),
)
