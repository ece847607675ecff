"""Measured yaw is off by a constant: ψ_measured = ψ + b."""

import math

import numpy as np
from sympy import cos, sin

from sym2real.effects.alike import ONE_HEADING, Member
from sym2real.effects.body import Body
from sym2real.effects.frames import HEADING
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.measured import reported, reporting
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import measuring
from sym2real.symbolic import Equations
from sym2real.trajectory import Array


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    sine, cosine = (reported(equations, name) for name in HEADING)
    turn_s, turn_c = sin(values["value"]), cos(values["value"])
    turned = {"sin_yaw": sine * turn_c + cosine * turn_s, "cos_yaw": cosine * turn_c - sine * turn_s}
    return reporting(equations, turned)


def _report(state: Array, body: Body, values: Numbers) -> Array:
    places = body.layouts.state.indices(HEADING)
    yaw = np.arctan2(*state[places]) + values["value"]
    state[places] = np.sin(yaw), np.cos(yaw)
    return state


YAW_BIAS = Kind(
    name="yaw_bias",
    stage="measurement",
    parameters=of_any_body(Parameter("value", "rad", null=0.0, low=-math.pi, high=math.pi, scale=0.05)),
    formula=r"\psi_m = \psi + b",
    summary="The measured heading is turned against the car's axis.",
    confused_with="a lever arm of the markers on one circle",
    shown_by="straight driving beside turns both ways",
    fix="turn the rigid body's axes in the motion capture by minus this angle",
    inject=measuring(_report),
    substitute=_substitute,
    needs=HEADING,
    robot="car",
    alike=(Member(ONE_HEADING, 0),),
    searching=Searching(shown_in=lambda _: (Shown.BOTH_WAYS,)),
)
