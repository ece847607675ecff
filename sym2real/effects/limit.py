"""A command is cut off at limits: a → clip(a, lower, upper).

It needs no memory, but it must come before what has some: firmware cuts a command off when it receives it, and
delays and lags follow the command that was cut off. A lag that follows the uncut command would take its time to come
back from where the robot never was. So it is the first of the filters. A servo's travel ends alike on both sides: one
magnitude then says both limits.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from sym2real.effects.body import Body
from sym2real.effects.kind import UNLIMITED, Kind, Numbers, Parameter
from sym2real.effects.memory import Given, Memory, first_row
from sym2real.effects.truth import on_column
from sym2real.protocols import Change


def _parameters(body: Body) -> tuple[Parameter, ...]:
    large = 100 * body.scale
    return (
        Parameter("lower", body.unit, null=-UNLIMITED, low=-large, high=0.0, scale=body.scale),
        Parameter("upper", body.unit, null=UNLIMITED, low=0.0, high=large, scale=body.scale),
        Parameter("magnitude", body.unit, null=UNLIMITED, low=0.0, high=large, scale=body.scale),
    )


def _cut(memory: Tensor, rows: Tensor, dt: float, values: Given) -> tuple[Tensor, Tensor]:
    lower = torch.maximum(values["lower"], -values["magnitude"])[..., None]
    upper = torch.minimum(values["upper"], values["magnitude"])[..., None]
    return memory, torch.maximum(torch.minimum(rows, upper), lower)


def _contradiction(values: Numbers) -> str:
    """No number lies between limits the wrong way round, or within a negative magnitude."""
    magnitude = values.get("magnitude", UNLIMITED)
    lower, upper = max(values.get("lower", -UNLIMITED), -magnitude), min(values.get("upper", UNLIMITED), magnitude)
    return "" if lower <= upper else f"expected a lower limit below the upper one, found {lower:g} and {upper:g}"


def _inject(body: Body, values: Numbers) -> Change:
    lower, upper = max(values["lower"], -values["magnitude"]), min(values["upper"], values["magnitude"])
    return on_column(body, lambda command: float(np.clip(command, lower, upper)))


LIMIT = Kind(
    name="limit",
    stage="filter",
    parameters=_parameters,
    formula=r"a \to \min(\max(a, a_\mathrm{lower}), a_\mathrm{upper}), |a| \le a_\mathrm{magnitude}",
    summary="A command beyond a limit is cut off at it.",
    confused_with="a gain below one, when most commands lie beyond the limit",
    shown_by="commands below and beyond the limit",
    fix="raise the limit in the actuator's firmware, or tell the controller about it",
    inject=_inject,
    memory=lambda body: Memory(first_row, _cut),
    columns="action",
    contradiction=_contradiction,
)
