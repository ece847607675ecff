"""Rotors that lift more in moving air: T (1 + k (u² + v²)), u and v the velocity along body x and y."""

from typing import Any

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.frames import QUATERNION, body_velocity
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.thrust import scaled
from sym2real.symbolic import Equations


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    ahead, left, _ = body_velocity(body)
    return scaled(equations, 1 + values["value"] * (ahead**2 + left**2))


def _lift(data: Any, body: Body, values: Numbers) -> None:
    along = truth.rotation(data).T @ truth.velocity(data)
    truth.scale_thrust(data, 1.0 + values["value"] * float(along[:2] @ along[:2]))


TRANSLATIONAL_LIFT = Kind(
    name="translational_lift",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "s²/m²", null=0.0, low=-0.2, high=0.5, scale=0.02)),
    formula=r"T \to T\,(1 + k\,(u^2 + v^2))",
    summary="Rotors lift more when air flows across them.",
    confused_with="a thrust gain at one speed",
    shown_by="level flight at several speeds beside hover",
    fix="put the term into the model",
    inject=truth.pushing(_lift),
    substitute=_substitute,
    needs=("thrust", "vx", "vy", "vz", *QUATERNION),
    robot="quadrotor",
    searching=Searching(shown_in=lambda _: (Shown.SPEEDS,)),
)
