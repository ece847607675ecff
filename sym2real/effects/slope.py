"""A floor that is not level: a constant force m·g in the plane."""

from typing import Any

import numpy as np

from sym2real.effects.alike import ONE_FORCE, Member
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.searching import Searching
from sym2real.effects.truth import editing
from sym2real.effects.wrench import push


def _tilt(spec: Any, body: Body, values: Numbers) -> None:
    """Gravity tilted, or tilted further, its size unchanged."""
    tilted = np.add(spec.option.gravity[:2], [values["gx"], values["gy"]])
    spec.option.gravity = [*tilted, -np.sqrt(GRAVITY**2 - tilted @ tilted)]


SLOPE = Kind(
    name="slope",
    stage="wrench",
    parameters=of_any_body(
        *(Parameter(name, "m/s²", null=0.0, low=-3.0, high=3.0, scale=0.3) for name in ("gx", "gy"))
    ),
    formula=r"F = m\,g_{xy}",
    summary="The floor is not level.",
    confused_with="wind, always",
    shown_by="driving in all directions",
    fix="level the floor, or keep the term in the model",
    inject=editing(_tilt),
    of_joints="gravity_tilt",
    substitute=lambda equations, values, body: push(
        equations, body, force=(body.mass * values["gx"], body.mass * values["gy"])
    ),
    needs=("vx", "vy"),
    numbers=("mass",),
    robot="car",
    alike=(Member(ONE_FORCE, 1),),
    searching=Searching(stood_for_by=lambda _: "wind"),
)
