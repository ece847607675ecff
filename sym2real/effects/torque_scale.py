"""Motors that turn the body by more or less than the model says: τ = (k_x τ_x, k_y τ_y, k_z τ_z).

What turns the body is torque over inertia, so that k_i is at once the factor on the lever (arm, reaction torque per
thrust) and the inverse of that on the inertia: no flight parts the two. Of published numbers of small robots the lever
about yaw is the least sure one, by an order of magnitude.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.simulated_rotors import places, pushes, reactions, require_rotors
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import MOTOR_TORQUES

NAMES = ("kx", "ky", "kz")


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return equations.substitute(
        {torque: values[name] * symbol(torque) for name, torque in zip(NAMES, MOTOR_TORQUES, strict=True)}
    )


def _turn(model: Any, data: Any, body: Body, values: Numbers) -> None:
    """What longer levers, and stronger reactions, add to the torque of what every rotor gives now."""
    x, y, _ = places(model, data, body).T
    more = [values[name] - 1.0 for name in NAMES] * np.array([y, -x, reactions(model, body)]).T
    truth.add_torque(data, pushes(model, data, body) @ more)


def _inject(body: Body, values: Numbers) -> Change:
    return Change("", edit=require_rotors, force=lambda model, data: _turn(model, data, body, values))


TORQUE_SCALE = Kind(
    name="torque_scale",
    stage="thrust",
    parameters=of_any_body(
        *(Parameter(name, "1", null=1.0, low=1e-3, high=1e3, scale=0.3, domain=POSITIVE) for name in NAMES)
    ),
    formula=r"\tau_i \to k_i\,\tau_i",
    summary="The motors turn the body by more or less than the model says: a lever or an inertia is another one.",
    confused_with="gains of all motors, which change the thrust as well; an inertia that is off is the same thing",
    shown_by="turns about all axes, to both sides: dither of the motors, each on its own",
    fix="set arm, reaction torque per thrust or inertia by this factor; a bifilar pendulum measures the inertia",
    inject=_inject,
    substitute=_substitute,
    needs=("thrust", *MOTOR_TORQUES, "wx", "wy", "wz"),
    robot="quadrotor",
)
