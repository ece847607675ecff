"""What brakes a turn of a robot on wheels by a constant torque: τ_z = -c sign(ω_z), beside what its file describes.

Wide wheels drill on the floor as the robot turns. One that touches along a line of length b, evenly loaded, does so
with μ N b/4, by the mean distance from its middle; in a simulator that lets it touch at both ends it is μ N b/2. So
what is missing may be less than nothing.
"""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.joint_push import raised
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.searching import Searching, Shown
from sym2real.symbolic.dry_friction import USUAL_DECELERATION
from sym2real.vocabulary import DRILLING, TURNING_INERTIA


def _parameters(body: Body) -> tuple[Parameter, ...]:
    described, scale = body.numbers.get(DRILLING, 0.0), USUAL_DECELERATION * body.numbers.get(TURNING_INERTIA, 1.0)
    return (Parameter("value", "N m", null=0.0, low=-described, high=max(30 * scale, described), scale=scale),)


def _brake(data: Any, _body: Body, values: Numbers) -> None:
    truth.add_torque(data, np.array([0.0, 0.0, -values["value"] * np.sign(truth.rates(data)[2])]))


TURNING_FRICTION = Kind(
    name="turning_friction",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau_z = -c\,\mathrm{sign}(\omega_z)",
    summary="Wheels that drill or scrub on the floor brake a turn by a constant torque.",
    confused_with="a gain of both wheels while the robot turns one way at one rate",
    shown_by="turns both ways, fast and slow",
    fix="put the torque into the model; narrower or rounder wheels drill less",
    inject=truth.pushing(_brake),
    substitute=lambda equations, values, _body: raised(equations, DRILLING, values["value"]),
    needs=(DRILLING,),
    numbers=(TURNING_INERTIA,),
    robot="car",
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)
