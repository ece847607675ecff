"""A point mass hangs at a site of the robot (a tool, a gripped part)."""

from typing import Any

import numpy as np

from sym2real.effects.body import Body
from sym2real.effects.joint_push import raised
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.truth import editing
from sym2real.vocabulary import load_quantity

POINT = 1e-9  # m²: squared radius of gyration of what MuJoCo takes for a point


def _parameters(body: Body) -> tuple[Parameter, ...]:
    scale = 0.05 * body.numbers.get("mass", 1.0)
    return (Parameter("value", "kg", null=0.0, low=0.0, high=20 * scale, scale=scale),)


def _hang(spec: Any, body: Body, values: Numbers) -> None:
    """A body of that mass, fixed where the site is."""
    site, mass = spec.site(body.column), values["value"]
    inertial = {"mass": mass, "ipos": [0.0] * 3, "inertia": [POINT * mass] * 3, "explicitinertial": True}
    between = np.reshape(site.fromto, (2, 3)).mean(0)  # NaN for a site that is given by its place
    hanging = site.parent.add_body(pos=site.pos if np.isnan(between).any() else between, **inertial)
    if site.frame is not None:
        hanging.set_frame(site.frame)


LOAD = Kind(
    name="load",
    stage="mass",
    parameters=_parameters,
    formula=r"m_\mathrm{site} \to m_\mathrm{site} + m",
    summary="A mass hangs at a point of the robot that the model does not know of.",
    confused_with="weaker actuators in one posture; an armature where gravity does not act on the joints",
    shown_by="several postures, and fast motion",
    fix="put the tool or the part into the description, with its mass where it hangs",
    inject=editing(_hang),
    substitute=lambda equations, values, body: raised(equations, load_quantity(body.column), values["value"]),
    needs=(load_quantity("{column}"),),
    robot="robot with joints",
    columns="site",
)
