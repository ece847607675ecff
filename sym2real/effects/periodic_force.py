"""A force that swings: F = A sin(ω t + φ) along world axes. The phase is free in every log."""

import math
from typing import Any

import numpy as np
from sympy import sin

from sym2real.effects.body import Body
from sym2real.effects.clock import with_time
from sym2real.effects.inputs import ANGLE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching
from sym2real.effects.truth import add_force, pushing
from sym2real.effects.wind import force_parameters
from sym2real.effects.wrench import push
from sym2real.symbolic import Equations, symbol


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (
        *force_parameters(body),
        Parameter("omega", "rad/s", null=1.0, low=0.2, high=60.0, scale=1.0),
        Parameter("phase", "rad", null=0.0, low=-math.pi, high=math.pi, scale=1.0, per_log=True),
    )


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    equations, time = with_time(equations)
    swing = sin(values["omega"] * time + values["phase"])
    sizes = [values[name] for name in ("fx", "fy", "fz") if name in values]
    return push(equations, body, force=[size * swing for size in sizes])


def _swing(data: Any, body: Body, values: Numbers) -> None:
    size = np.array([values.get(name, 0.0) for name in ("fx", "fy", "fz")])
    add_force(data, size * np.sin(values["omega"] * data.time + values["phase"]))


PERIODIC_FORCE = Kind(
    name="periodic_force",
    stage="wrench",
    parameters=_parameters,
    formula=r"F = A \sin(\omega t + \varphi)",
    summary="A force swings at a fixed frequency: gusts, a hanging load, a fan.",
    confused_with="wind in logs shorter than a period",
    shown_by="logs of at least three periods",
    fix="find what swings at that frequency and stop it, or estimate the force in flight",
    inject=pushing(_swing),
    substitute=_substitute,
    needs=("vx", "vy"),
    numbers=("mass",),
    searching=Searching(given={"omega": 0.0, "phase": symbol(ANGLE)}),
)
