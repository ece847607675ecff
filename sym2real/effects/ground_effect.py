"""More thrust near the ground: T (1 + g e^(-z/0.07 m))."""

from typing import Any

import numpy as np
from sympy import exp

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.thrust import scaled
from sym2real.symbolic import symbol

REACH = 0.07  # m


def _lift(data: Any, body: Body, values: Numbers) -> None:
    height = float(data.qpos[2])
    truth.scale_thrust(data, 1.0 + values["value"] * float(np.exp(-height / 0.07)))


GROUND_EFFECT = Kind(
    name="ground_effect",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=0.0, low=0.0, high=2.0, scale=0.2)),
    formula=r"T \to T\,(1 + g\,e^{-z / 0.07\,\mathrm{m}})",
    summary="Close to the ground the rotors' own air lifts the robot.",
    confused_with="less mass or more thrust at one height; trim of the thrust that differs from flight to flight",
    shown_by="at least three low flights whose height moves between 0.05 and 0.3 m",
    fix="fly higher than three rotor diameters, or keep the term in the model",
    inject=truth.pushing(_lift),
    substitute=lambda equations, values, body: scaled(equations, 1 + values["value"] * exp(-symbol("z") / REACH)),
    needs=("thrust", "z"),
    robot="quadrotor",
    searching=Searching(shown_in=lambda _: (Shown.LOW,)),
)
