"""A constant deceleration against the motion: F = -r·m·sign(u) along the heading."""

from typing import Any

import numpy as np
from sympy import sign

from sym2real.effects import truth
from sym2real.effects.alike import ONE_PULL, Member
from sym2real.effects.body import Body
from sym2real.effects.car_turning import FORWARD, forward_speed, push_ahead
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.searching import Searching, Shown


def _brake(data: Any, body: Body, values: Numbers) -> None:
    ahead = truth.rotation(data)[:, 0]
    truth.add_force(data, -values["value"] * body.mass * np.sign(ahead @ truth.velocity(data)) * ahead)


ROLLING_RESISTANCE = Kind(
    name="rolling_resistance",
    stage="wrench",
    parameters=of_any_body(Parameter("value", "m/s²", null=0.0, low=0.0, high=5.0, scale=0.5)),
    formula=r"F = -r\,m\,\mathrm{sign}(u)",
    summary="Bearings, gears or a soft floor brake the car by a constant force.",
    confused_with="an offset of the speed command, always; a speed gain at one speed",
    shown_by="four speeds, forwards and backwards",
    fix="free the drive train, or raise the speed loop's integral part",
    inject=truth.pushing(_brake),
    of_joints="joint_friction",
    substitute=lambda equations, values, body: push_ahead(
        equations, body, -values["value"] * body.mass * sign(forward_speed(body))
    ),
    needs=FORWARD,
    numbers=("mass",),
    robot="car",
    alike=(Member(ONE_PULL, 0),),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
