"""Wheels larger or smaller than nominal, one or all: r → k·r, so that they turn 1/k times as much per metre."""

from typing import Any

from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.joint_push import multiplied
from sym2real.effects.kind import Kind, Numbers, Parameter, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import editing
from sym2real.vocabulary import DRILLING, rate_per_speed

# mujoco.mjtGeom, capsules and cylinders: their first size is the radius, the next one half the length.
LONG = (3, 5)


def wheels_of(body: Body) -> tuple[str, ...]:
    """The bound wheel, or all of them."""
    return (body.column,) if body.column else body.joints


def _resize(spec: Any, body: Body, values: Numbers) -> None:
    """Of what turns with a wheel the size across its axle, and the axle's height: the robot stands as before."""
    for wheel in wheels_of(body):
        turning = spec.joint(wheel).parent
        x, y, z = turning.pos
        turning.pos = [x, y, z + (values["value"] - 1.0) * max(geom.size[0] for geom in turning.geoms)]
        for geom in turning.geoms:
            radius, *others = values["value"] * geom.size
            geom.size = [radius, *(geom.size[1:] if int(geom.type) in LONG else others)]


WHEEL_RADIUS = Kind(
    name="wheel_radius",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.5, high=2.0, scale=0.05, domain=POSITIVE)),
    formula=r"r \to k\,r",
    summary="A wheel, or all of them, rolls on a larger or smaller radius than nominal.",
    confused_with="a gain of the wheels' commands beside a damping, which together are the same",
    shown_by="straight drives at several speeds; a wheel alone also by the way a straight drive bends",
    fix="measure the way of some turns of the wheels, under load, and set the radius in the model",
    inject=editing(_resize),
    substitute=lambda equations, values, body: multiplied(
        equations, map(rate_per_speed, wheels_of(body)), 1 / values["value"]
    ),
    needs=(DRILLING,),
    robot="car",
    columns="joint",
    column_needed=False,
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
