"""The measured point is not the rear axle's middle: p_measured = p + R(ψ) r, and its velocity with it."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from sym2real.effects.alike import ONE_ARM, ONE_HEADING, Member
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.manoeuvres import one_circle
from sym2real.effects.measured import reported, reporting
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import measuring
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array, Trajectory


def _parameters(body: Body) -> tuple[Parameter, ...]:
    """What is measured is a point of the robot: a wheelbase ahead or behind, half of one aside."""
    longest = body.numbers.get("wheelbase", 1.0)
    bounds = {"rx": longest, "ry": longest / 2}
    return tuple(Parameter(name, "m", null=0.0, low=-most, high=most, scale=0.05) for name, most in bounds.items())


def _arm(sine: Any, cosine: Any, values: Any) -> tuple[Any, Any]:
    return cosine * values["rx"] - sine * values["ry"], sine * values["rx"] + cosine * values["ry"]


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    along, across = _arm(symbol("sin_yaw"), symbol("cos_yaw"), values)
    moved = {"x": along, "y": across}
    if "wz" in body.layouts.state:
        moved |= {"vx": -symbol("wz") * across, "vy": symbol("wz") * along}
    return reporting(equations, {name: reported(equations, name) + step for name, step in moved.items()})


def _report(state: Array, body: Body, values: Numbers) -> Array:
    """State of that point of the body: position (m) by the turned arm, velocity (m/s) by the rate across it."""
    layout, arm = body.layouts.state, [values["rx"], values["ry"], 0.0]
    yaw = float(np.arctan2(state[layout.index("sin_yaw")], state[layout.index("cos_yaw")]))
    turned = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]) @ arm
    state[layout.indices(("x", "y"))] += turned[:2]
    state[layout.indices(("vx", "vy"))] += np.cross([0.0, 0.0, state[layout.index("wz")]], turned)[:2]
    return state


def _fixed(_body: Body, _values: Array, logs: Iterable[Trajectory]) -> tuple[str, ...]:
    """On one circle an arm aside is the speed's: its gain, its limit."""
    return ("ry",) if one_circle(logs) else ()


LEVER_ARM = Kind(
    name="lever_arm",
    stage="measurement",
    parameters=_parameters,
    formula=r"p_m = p + R(\psi)\,r",
    summary="The motion capture measures a point away from the rear axle's middle.",
    confused_with="a yaw bias on one circle",
    shown_by="straight driving beside turns both ways",
    fix="move the rigid body's origin in the motion capture by minus this arm",
    inject=measuring(_report),
    substitute=_substitute,
    needs=("x", "y", "sin_yaw", "cos_yaw"),
    robot="car",
    alike=(Member(ONE_HEADING, 1), Member(ONE_ARM, 0)),
    searching=Searching(fixed=_fixed, shown_in=lambda _: (Shown.BOTH_WAYS,)),
)
