"""Forces on a body from outside: of the air and whatever else pulls.

``wind``. A constant force along world axes.

``linear_drag``. Drag in proportion to speed, along body axes: F = -c∘v.

``quadratic_drag``. Drag in proportion to the square of speed: F = -c‖v‖v.

``periodic_force``. A force that swings: F = A sin(ω t + φ) along world axes. The phase is free in every log.
"""

import math
from typing import Any

import numpy as np
from sympy import sin

from sym2real.effects import truth
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.frames import body_velocity, norm, to_world, velocity
from sym2real.effects.inputs import ANGLE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, several
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.terms import with_time
from sym2real.effects.wrench import apply_wrench
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import SPEED_COLUMN


def _force_parameters(body: Body) -> tuple[Parameter, ...]:
    """Components of a force in N: two in a plane."""
    scale = 0.1 * GRAVITY * body.numbers.get("mass", 1.0)
    names = ("fx", "fy", "fz")[: len(velocity(body))]
    return several(names, "N", null=0.0, low=-10 * scale, high=10 * scale, scale=scale)


WIND = Kind(
    name="wind",
    stage="wrench",
    parameters=_force_parameters,
    formula=r"F = \mathrm{const} \;\text{(world)}",
    summary="A steady force along world axes: wind, a pulling cable.",
    confused_with="a tilted mounting of the sensor while yaw stays; a slope under a car",
    shown_by="yaw that turns at 0.5 to 0.8 rad/s",
    fix="shield the robot, or use the model that has the force; where it follows the weather, estimate it in flight",
    inject=truth.with_force(
        lambda data, body, values: truth.add_force(
            data, np.array([values.get(name, 0.0) for name in ("fx", "fy", "fz")])
        )
    ),
    substitute=lambda equations, values, body: apply_wrench(equations, body, force=tuple(values.values())),
    needs=("vx", "vy"),
    numbers=("mass",),
    # A vertical force is thrust's: mass, its map, its offset.
    searching=Searching(fixed=lambda _body, _values, _logs: ("fz",), shown_in=lambda _: (Shown.YAW,)),
)


def _linear_drag_parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    names = ("cx", "cy", "cz")[: len(velocity(body))]
    return several(names, "N s/m", null=0.0, low=0.0, high=5 * mass, scale=0.3 * mass)


def _linear_drag_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    coefficients = list(values.values())
    if all(value == coefficients[0] for value in coefficients):
        return apply_wrench(equations, body, force=[-coefficients[0] * speed for speed in velocity(body)])
    along = [-value * speed for value, speed in zip(coefficients, body_velocity(body), strict=True)]
    return apply_wrench(equations, body, force=to_world(body, along))


def _linear_drag_brake(data: Any, body: Body, values: Numbers) -> None:
    coefficients, turned = [values.get(name, 0.0) for name in ("cx", "cy", "cz")], truth.rotation(data)
    truth.add_force(data, -turned @ (coefficients * (turned.T @ truth.velocity(data))))


def _stood_for_by(body: Body) -> str:
    """A gain, of a car that is at its speed at once: what brakes in proportion to it lowers it so."""
    return f"gain:{SPEED_COLUMN}" if body.at_its_speed else ""


LINEAR_DRAG = Kind(
    name="linear_drag",
    stage="wrench",
    parameters=_linear_drag_parameters,
    formula=r"F = -c \circ v \;\text{(body)}",
    summary="Air or rotors brake in proportion to speed.",
    confused_with="quadratic drag in hover or at one speed; wind on one straight flight",
    shown_by="several speeds between 0.5 and 1.6 m/s, in both directions",
    fix="put the drag into the model; a smaller frame or guards off lower it",
    inject=truth.with_force(_linear_drag_brake),
    of_joints="joint_damping",
    substitute=_linear_drag_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    searching=Searching(stood_for_by=_stood_for_by, shown_in=lambda _: (Shown.SPEEDS,)),
)


def _quadratic_drag_parameters(body: Body) -> tuple[Parameter, ...]:
    mass = body.numbers.get("mass", 1.0)
    return (Parameter("value", "N s²/m²", null=0.0, low=0.0, high=5 * mass, scale=0.3 * mass),)


def _quadratic_drag_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    speed = norm(velocity(body))
    return apply_wrench(equations, body, force=[-values["value"] * speed * component for component in velocity(body)])


def _quadratic_drag_brake(data: Any, body: Body, values: Numbers) -> None:
    moving = truth.velocity(data)
    if body.planar:
        moving[2] = 0.0
    truth.add_force(data, -values["value"] * float(np.linalg.norm(moving)) * moving)


QUADRATIC_DRAG = Kind(
    name="quadratic_drag",
    stage="wrench",
    parameters=_quadratic_drag_parameters,
    formula=r"F = -c\,\|v\|\,v",
    summary="Air brakes in proportion to the square of speed.",
    confused_with="linear drag in hover or at one speed",
    shown_by="several speeds between 0.5 and 1.6 m/s",
    fix="put the drag into the model; less frontal area lowers it",
    inject=truth.with_force(_quadratic_drag_brake),
    substitute=_quadratic_drag_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)


def _periodic_force_parameters(body: Body) -> tuple[Parameter, ...]:
    return (
        *_force_parameters(body),
        Parameter("omega", "rad/s", null=1.0, low=0.2, high=60.0, scale=1.0),
        Parameter("phase", "rad", null=0.0, low=-math.pi, high=math.pi, scale=1.0, per_log=True),
    )


def _periodic_force_substitute(equations: Equations, values: Values, body: Body) -> Equations:
    equations, time = with_time(equations)
    swing = sin(values["omega"] * time + values["phase"])
    sizes = [values[name] for name in ("fx", "fy", "fz") if name in values]
    return apply_wrench(equations, body, force=[size * swing for size in sizes])


def _swing(data: Any, body: Body, values: Numbers) -> None:
    size = np.array([values.get(name, 0.0) for name in ("fx", "fy", "fz")])
    truth.add_force(data, size * np.sin(values["omega"] * data.time + values["phase"]))


PERIODIC_FORCE = Kind(
    name="periodic_force",
    stage="wrench",
    parameters=_periodic_force_parameters,
    formula=r"F = A \sin(\omega t + \varphi)",
    summary="A force swings at a fixed frequency: gusts, a hanging load, a fan.",
    confused_with="wind in logs shorter than a period",
    shown_by="logs of at least three periods",
    fix="find what swings at that frequency and stop it, or estimate the force in flight",
    inject=truth.with_force(_swing),
    substitute=_periodic_force_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    searching=Searching(given={"omega": 0.0, "phase": symbol(ANGLE)}),
)
