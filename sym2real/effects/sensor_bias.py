"""A measurement is off by a constant: y → y + b."""

from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.measured import reported, reporting
from sym2real.effects.searching import SETTLED, Searching, by_role
from sym2real.effects.truth import measuring
from sym2real.trajectory import Array
from sym2real.vocabulary import JOINT_ANGLE, JOINT_DISPLACEMENT


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", body.unit, null=0.0, low=-20 * body.scale, high=20 * body.scale, scale=body.scale),)


def _report(state: Array, body: Body, values: Numbers) -> Array:
    state[body.layouts.state.index(body.column)] += values["value"]
    return state


SENSOR_BIAS = Kind(
    name="sensor_bias",
    stage="measurement",
    parameters=_parameters,
    formula=r"y_m = y + b",
    summary="A sensor adds a constant.",
    confused_with="a trim of the command that drives the same column",
    shown_by="the robot at rest, where the true value is known",
    fix="calibrate the sensor at rest",
    inject=measuring(_report),
    substitute=lambda equations, values, body: reporting(
        equations, {body.column: reported(equations, body.column) + values["value"]}
    ),
    columns="state",
    searching=Searching(why_not=by_role({JOINT_ANGLE.name: "", JOINT_DISPLACEMENT.name: ""}, SETTLED)),
)
