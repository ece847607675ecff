"""The on-board attitude loop is slower or faster than nominal: q goes to q_cmd in k τ, not in τ.

Over a step of dt the attitude goes the part p = 1 - e^(-dt/τ) of the way to the command. To go the part p(kτ) instead,
the nominal loop is given the command that lies p(kτ)/p(τ) of the way off.
"""

from sympy import Expr, exp, sign

from sym2real.effects.body import Body
from sym2real.effects.domain import POSITIVE
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.manoeuvres import EXCITED
from sym2real.errors import ModelError
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.vocabulary import ATTITUDE, ATTITUDE_COMMAND

TIME = "attitude_time"  # the number τ of a robot that is told an attitude, s


def _part(time: Expr | float, dt: float) -> Expr:
    return 1 - exp(-dt / time)


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    time, start = body.number(TIME), [symbol(column) for column in ATTITUDE.columns]
    further = _part(values["value"] * time, body.dt) / _part(time, body.dt)
    told = [symbol(column) for column in ATTITUDE_COMMAND.columns]
    same_side = sign(sum(a * b for a, b in zip(start, told, strict=True)))
    moved = [a + further * (same_side * b - a) for a, b in zip(start, told, strict=True)]
    return equations.substitute(dict(zip(ATTITUDE_COMMAND.columns, moved, strict=True)))


def _inject(body: Body, values: Numbers) -> Change:
    raise ModelError("attitude_loop: no simulated robot here is told an attitude")


ATTITUDE_LOOP = Kind(
    name="attitude_loop",
    stage="loop",
    parameters=of_any_body(Parameter("value", "1", null=1.0, low=0.1, high=10.0, scale=0.3, domain=POSITIVE)),
    formula=r"\tau \to k\,\tau",
    summary="The on-board attitude loop is slower or faster than the nominal one.",
    confused_with="a lag of the attitude commands, where the loop is fast beside it",
    shown_by=EXCITED,
    fix="multiply the model's time constant by it (`nominal quadrotor --attitude-time-constant`)",
    inject=_inject,
    substitute=_substitute,
    needs=(*ATTITUDE_COMMAND.columns, *ATTITUDE.columns),
    numbers=(TIME,),
    robot="quadrotor",
)
