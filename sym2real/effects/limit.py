"""A command is cut off at limits: a → clip(a, lower, upper)."""

from __future__ import annotations

import numpy as np
from sympy import Max, Min

from sym2real.effects.body import Body
from sym2real.effects.effect import UNLIMITED, Kind, Numbers, Parameter, Values
from sym2real.effects.truth import on_column
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol


def _parameters(body: Body) -> tuple[Parameter, ...]:
    large = 100 * body.scale
    return (
        Parameter("lower", body.unit, null=-UNLIMITED, low=-large, high=0.0, scale=body.scale),
        Parameter("upper", body.unit, null=UNLIMITED, low=0.0, high=large, scale=body.scale),
    )


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    bounded = symbol(body.column)
    upper, lower = values["upper"], values["lower"]
    if not (upper.is_number and upper >= UNLIMITED):
        bounded = Min(bounded, upper)
    if not (lower.is_number and lower <= -UNLIMITED):
        bounded = Max(bounded, lower)
    return equations.substitute({body.column: bounded})


def _inject(body: Body, values: Numbers) -> Change:
    return on_column(body, lambda command: float(np.clip(command, values["lower"], values["upper"])))


LIMIT = Kind(
    name="limit",
    stage="command",
    parameters=_parameters,
    formula=r"a \to \min(\max(a, a_\mathrm{lower}), a_\mathrm{upper})",
    summary="A command beyond a limit is cut off at it.",
    confused_with="a gain below one, when most commands lie beyond the limit",
    shown_by="commands below and beyond the limit",
    fix="raise the limit in the actuator's firmware, or tell the controller about it",
    inject=_inject,
    substitute=_substitute,
    columns="action",
)
