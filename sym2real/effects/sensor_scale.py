"""A measurement is a multiple of the truth: y → k·y. A factor of -1 is ``sensor_sign``."""

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.measured import reported, reporting
from sym2real.effects.searching import SETTLED, Searching
from sym2real.effects.truth import measuring
from sym2real.symbolic import Equations
from sym2real.trajectory import Array


def multiplied(equations: Equations, values: Values, body: Body) -> Equations:
    """The measured column times a factor."""
    return reporting(equations, {body.column: reported(equations, body.column) * values["value"]})


@measuring
def multiplying(state: Array, body: Body, values: Numbers) -> Array:
    """Its truth."""
    state[body.layouts.state.index(body.column)] *= values["value"]
    return state


SENSOR_SCALE = Kind(
    name="sensor_scale",
    stage="measurement",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.01, high=100.0, scale=0.1)),
    formula=r"y_m = k\,y",
    summary="A sensor reports what it measures times a factor.",
    confused_with="a gain of the command that drives the same column",
    shown_by="motion that another channel measures too: rates against the attitude's derivative",
    fix="calibrate the sensor",
    inject=multiplying,
    substitute=multiplied,
    columns="state",
    searching=Searching(why_not=lambda _: SETTLED),
)
