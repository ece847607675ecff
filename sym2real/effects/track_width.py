"""Wheels further apart, or closer, than nominal: b → k·b, so that a difference of their rates turns less, or more."""

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.joint_push import multiplied
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import editing, placed
from sym2real.vocabulary import DRILLING, wheel_lever

UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


def _widen(spec: Any, body: Body, values: Numbers) -> None:
    """Wheels further from the robot's middle, on whatever bodies they are mounted."""
    plain = spec.copy().compile()
    for joint in body.joints:
        wheel, number = spec.joint(joint).parent, int(plain.jnt_bodyid[plain.joint(joint).id])
        (_, y, _), axes = placed(plain, int(plain.body_parentid[number]), plain.body_pos[number], UNTURNED)
        wheel.pos = wheel.pos + (values["value"] - 1.0) * y * axes[1]


TRACK_WIDTH = Kind(
    name="track_width",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.5, high=2.0, scale=0.05, domain=POSITIVE)),
    formula=r"b \to k\,b",
    summary="The wheels of an axle touch the floor further apart, or closer, than nominal.",
    confused_with="the radius of all wheels while the robot turns on the spot",
    shown_by="turns on the spot beside straight drives",
    fix="turn on the spot some times round, and set the width that makes the odometry agree in the model",
    inject=editing(_widen),
    substitute=lambda equations, values, body: multiplied(equations, map(wheel_lever, body.joints), values["value"]),
    needs=(DRILLING,),
    robot="car",
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)
