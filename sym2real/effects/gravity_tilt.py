"""The base stands askew: gravity is turned by small angles about the world's x and y axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from sympy import cos, sin

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import GRAVITY_COMPONENTS


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, "rad", null=0.0, low=-0.5, high=0.5, scale=0.03) for name in ("roll", "pitch"))


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    """Gravity in the axes of a base that is rolled, then pitched."""
    x, y, z = (symbol(name) for name in GRAVITY_COMPONENTS)
    roll, pitch = values["roll"], values["pitch"]
    level = x * cos(pitch) - z * sin(pitch)
    down = x * sin(pitch) + z * cos(pitch)
    turned = (level, y * cos(roll) + down * sin(roll), down * cos(roll) - y * sin(roll))
    return equations.substitute(dict(zip(GRAVITY_COMPONENTS, turned, strict=True)))


def _inject(body: Body, values: Numbers) -> Change:
    def edit(spec: Any) -> None:
        """Rotate the vector by the two angles, one after the other."""
        pitch, roll = values["pitch"], values["roll"]
        about_y = np.array([[np.cos(pitch), 0, -np.sin(pitch)], [0, 1, 0], [np.sin(pitch), 0, np.cos(pitch)]])
        about_x = np.array([[1, 0, 0], [0, np.cos(roll), np.sin(roll)], [0, -np.sin(roll), np.cos(roll)]])
        spec.option.gravity = about_x @ about_y @ np.array(spec.option.gravity)

    return Change("", edit=edit)


GRAVITY_TILT = Kind(
    name="gravity_tilt",
    stage="mass",
    parameters=_parameters,
    formula=r"g \to R_x(\phi) R_y(\theta) g",
    summary="The robot's base stands askew, so that gravity pulls from another side.",
    confused_with="an offset of the actuators in one posture",
    shown_by="several postures",
    fix="level the base, or tell the model how it stands",
    inject=_inject,
    substitute=_substitute,
    needs=GRAVITY_COMPONENTS,
    robot="robot with joints",
)
