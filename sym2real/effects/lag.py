"""An actuator approaches its command as a first-order filter: τ da'/dt = a - a'."""

from typing import Any

from sym2real.effects.alike import ONE_LAG, ONE_WAY_TO_TURN, Member
from sym2real.effects.body import Body
from sym2real.effects.domain import NOT_NEGATIVE
from sym2real.effects.kind import Kind, Numbers, Parameter
from sym2real.effects.memory import lag
from sym2real.effects.searching import Searching, Shown, alone_on, by_role, steps
from sym2real.effects.truth import actuators, editing, set_lag


def _parameters(body: Body) -> tuple[Parameter, ...]:
    return (Parameter("value", "s", null=0.0, low=0.0, high=1.0, scale=2 * body.dt, domain=NOT_NEGATIVE),)


def _slow(spec: Any, body: Body, values: Numbers) -> None:
    """MuJoCo's actuator dynamics."""
    for actuator in actuators(spec, body):
        set_lag(spec, actuator, values["value"])


LAG = Kind(
    name="lag",
    stage="filter",
    parameters=_parameters,
    formula=r"\tau \dot a' = a - a'",
    summary="The actuator approaches its command as a first-order filter.",
    confused_with="a delay; a common lag of the rate commands also with motor lag",
    shown_by="steps of the command that are held longer than the time constant",
    fix="stiffen the actuator's own loop, or let the controller plan with the lag",
    inject=editing(_slow),
    memory=lambda body: lag(),
    columns="action",
    column_needed=False,
    lagging=True,
    alike=(Member(ONE_LAG, 1, "w?_cmd"), Member(ONE_LAG, 2), Member(ONE_WAY_TO_TURN, 0, "steer")),
    searching=Searching(
        why_not=alone_on("motors"),
        starts=steps(2.5),
        shown_in=by_role({"speed": (Shown.DITHER, Shown.SPEEDS, Shown.SWINGING_SPEED)}, (Shown.DITHER,)),
    ),
)
