"""A constant is added to a command: a → a + b."""

from sym2real.effects import truth
from sym2real.effects.alike import ONE_LIFT, ONE_MAP, ONE_PULL, ONE_THRUST, ONE_TORQUE, ONE_TORQUE_AT_ONE_THRUST, Member
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values
from sym2real.effects.searching import Searching, Shown, alone_on, by_role
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", body.unit, null=0.0, low=-10 * body.scale, high=10 * body.scale, scale=body.scale),)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    return equations.substitute({body.column: symbol(body.column) + values["value"]})


def _inject(body: Body, values: Numbers) -> Change:
    if body.column in body.quantities:  # the thrust of motors, whose torques stay
        return truth.pushing(lambda data, _, known: truth.add_thrust(data, known["value"]))(body, values)
    return truth.commanding(lambda command, _, known: command + known["value"])(body, values)


OFFSET = Kind(
    name="offset",
    stage="command",
    parameters=_parameters,
    formula=r"a \to a + b",
    summary="The robot adds a constant to a command.",
    confused_with="a gain while the command hardly varies; for rate commands a torque bias or centre-of-mass offset",
    shown_by="commands of both signs, or of several sizes",
    fix="trim the actuator by minus this offset (servo centre, thrust trim), or subtract it from the command",
    inject=_inject,
    substitute=_substitute,
    columns="action",
    alike=(
        Member(ONE_THRUST, 2, "thrust"),
        Member(ONE_MAP, 2, "thrust"),
        Member(ONE_LIFT, 1, "thrust"),
        Member(ONE_TORQUE, 1, "w?_cmd"),
        Member(ONE_TORQUE_AT_ONE_THRUST, 2, "w?_cmd"),
        Member(ONE_PULL, 1, "speed"),
        Member(ONE_PULL, 2, "acceleration"),
    ),
    searching=Searching(
        why_not=alone_on("motors"),
        stood_for_by=by_role({"rate command": "torque_bias"}, ""),
        shown_in=by_role({"speed": (Shown.SPEEDS,), "steering": (Shown.BOTH_WAYS,)}, ()),
    ),
    by_torque=by_role({"rate command": True}, False),
)
