"""A steering map that bends: right about the middle, wrong at full lock, δ → δ (1 - c δ²).

The equations turn a car by tan δ of one angle. A linkage that turns both front wheels alike, where a turn asks more of
the inner one, turns it by less the further they are turned (no Ackermann geometry: D. Gillespie, Fundamentals of
Vehicle Dynamics, ch. 8); so does a servo's arm that runs on a circle, and what is logged as an angle and is a travel.
"""

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown
from sym2real.effects.truth import commanding
from sym2real.symbolic import Equations, symbol


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    steer = symbol("steer")
    return equations.substitute({"steer": steer * (1 - values["value"] * steer**2)})


STEERING_CURVE = Kind(
    name="steering_curve",
    stage="command",
    parameters=of_any_body(Parameter("value", "1/rad²", null=0.0, low=-2.0, high=2.0, scale=0.3)),
    formula=r"\delta \to \delta\,(1 - c\,\delta^2)",
    summary="The steering map is bent: right about the middle, wrong at full lock.",
    confused_with="a steering gain, on one circle",
    shown_by="small and large steering angles both ways",
    fix="measure the wheels' angle against the command at several angles, and put that curve into the driver",
    inject=commanding(lambda steer, _, values: steer * (1.0 - values["value"] * steer**2), "steer"),
    substitute=_substitute,
    needs=("steer",),
    robot="car",
    searching=Searching(varying=("steer",), shown_in=lambda _: (Shown.BOTH_WAYS, Shown.HARD)),
)
