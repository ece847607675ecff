"""Blades that flap in moving air turn the body: τ = (a·v, b·u, 0), u and v the velocity along body x and y."""

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.frames import QUATERNION, body_velocity
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations


def _parameters(body: Body) -> tuple[Parameter, ...]:
    # At 1 m/s the torque is that of the weight at a tenth of a millimetre.
    scale = 1e-4 * GRAVITY * body.numbers.get("mass", 1.0)
    return tuple(
        Parameter(name, "N s", null=0.0, low=-500 * scale, high=500 * scale, scale=scale) for name in ("a", "b")
    )


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    ahead, left, _ = body_velocity(body)
    return push(equations, body, torque=(values["a"] * left, values["b"] * ahead))


def _turn(data: Any, body: Body, values: Numbers) -> None:
    along = truth.rotation(data).T @ truth.velocity(data)
    truth.add_torque(data, np.array([values["a"] * along[1], values["b"] * along[0], 0.0]))


FLAPPING_MOMENT = Kind(
    name="flapping_moment",
    stage="wrench",
    parameters=_parameters,
    formula=r"\tau = (a\,v,\; b\,u,\; 0)",
    summary="Air that flows across the rotors tilts their discs and turns the body.",
    confused_with="a torque bias at one velocity, and drag",
    shown_by="several speeds in all directions of the body",
    fix="put the term into the model",
    inject=truth.pushing(_turn),
    substitute=_substitute,
    needs=("wx", "wy", "vx", "vy", "vz", *QUATERNION),
    robot="quadrotor",
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
    by_torque=lambda _: True,
)
