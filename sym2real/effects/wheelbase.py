"""Another distance between the axles: L → k·L, so that tan(steer) turns the car 1/k times as much."""

from typing import Any

from sympy import atan, tan

from sym2real.effects.alike import ONE_TURN, Member
from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import editing
from sym2real.symbolic import Equations, symbol

FRONT = 0.1  # m: wheels further ahead than this are the front axle


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return equations.substitute({"steer": atan(tan(symbol("steer")) / values["value"])})


def _stretch(spec: Any, body: Body, values: Numbers) -> None:
    for wheel in spec.worldbody.first_body().bodies:
        if wheel.pos[0] > FRONT:
            wheel.pos = [values["value"] * wheel.pos[0], *list(wheel.pos)[1:]]


WHEELBASE = Kind(
    name="wheelbase",
    stage="thrust",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.5, high=2.0, scale=0.1, domain=POSITIVE)),
    formula=r"L \to k\,L",
    summary="The axles are further apart, or closer, than nominal.",
    confused_with="a steering gain at low speed, always",
    shown_by="small and large steering angles; better: a ruler",
    fix="measure the wheelbase and set it in the model",
    inject=editing(_stretch),
    substitute=_substitute,
    needs=("steer",),
    robot="car",
    alike=(Member(ONE_TURN, 0),),
    searching=Searching(stood_for_by=lambda _: "gain:steer", varying=("steer",), shown_in=lambda _: (Shown.BOTH_WAYS,)),
)
