"""A command is answered with a multiple of it: a → k·a."""

from sym2real.effects.alike import (
    ONE_CURVE,
    ONE_MAP,
    ONE_ROTOR,
    ONE_STEERING,
    ONE_STRENGTH,
    ONE_THRUST,
    ONE_TURN,
    Member,
)
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching, Shown, alone_on, by_role
from sym2real.effects.thrust import scaled
from sym2real.effects.truth import commanding
from sym2real.layout import turned_by_motors
from sym2real.symbolic import Equations, symbol

LEAST, MOST = 0.2, 3.0  # what is likely


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    if body.column in equations.quantities:
        return scaled(equations, values["value"])
    return equations.substitute({body.column: values["value"] * symbol(body.column)})


def _stood_for_by(body: Body) -> str:
    """A mass, but where motors turn the body as well: their torques show how strong they are."""
    return "added_mass" if body.role == "thrust" and not turned_by_motors(body.layouts) else ""


GAIN = Kind(
    name="gain",
    stage="command",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=LEAST, high=MOST, scale=0.1)),
    formula=r"a \to k\,a",
    summary="The robot answers a command with a fixed multiple of it.",
    confused_with="an offset while the command hardly varies; for thrust also added mass, unless motors turn the body",
    shown_by="commands over a wide range, through zero where the robot allows it",
    fix="correct the map from command to actuator (thrust per unit, servo travel, speed per unit) by this factor",
    inject=commanding(lambda command, _, values: command * values["value"]),
    substitute=_substitute,
    columns="action",
    alike=(
        Member(ONE_STRENGTH, 1, "thrust"),
        Member(ONE_THRUST, 1, "thrust"),
        Member(ONE_MAP, 1, "thrust"),
        Member(ONE_ROTOR, 0, "thrust"),
        Member(ONE_TURN, 1, "steer"),
        Member(ONE_STEERING, 0, "steer"),
        Member(ONE_CURVE, 0, "steer"),
    ),
    searching=Searching(
        why_not=alone_on("motors"),
        stood_for_by=_stood_for_by,
        shown_in=by_role({"speed": (Shown.SPEEDS,)}, ()),
    ),
)
