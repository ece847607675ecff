"""Thrust that bends against its command: T → T₀ (T/T₀)^p, T₀ the hover thrust."""

from sympy import Max

from sym2real.effects.alike import ONE_MAP, ONE_ROTOR, Member
from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.thrust import hover_thrust, scaled
from sym2real.effects.truth import commanding
from sym2real.symbolic import Equations, symbol

# Below this share of the hover thrust the curve goes straight to zero: its slope there would be infinite for p < 1.
STRAIGHT_BELOW = 0.01


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    hover = hover_thrust(body)
    return scaled(equations, Max(symbol("thrust") / hover, STRAIGHT_BELOW) ** (values["value"] - 1))


def _bend(command: float, body: Body, values: Numbers) -> float:
    hover = body.mass * GRAVITY
    return float(hover * (max(command, 0.0) / hover) ** values["value"])


THRUST_CURVE = Kind(
    name="thrust_curve",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.3, high=3.0, scale=0.2)),
    formula=r"T \to T_0\,(T/T_0)^p",
    summary="The thrust map is bent: right in hover, wrong above and below.",
    confused_with="a thrust gain with an offset, where thrust varies little",
    shown_by="thrust over a wide range: hard climbs and descents",
    fix="measure thrust against command on a scale and replace the thrust map",
    inject=commanding(_bend, "thrust"),
    substitute=_substitute,
    needs=("thrust",),
    numbers=("mass",),
    robot="quadrotor",
    alike=(Member(ONE_MAP, 3), Member(ONE_ROTOR, 1)),
    searching=Searching(shown_in=lambda _: (Shown.CLIMBS,)),
)
