"""What becomes of a command at once: a multiple, a constant beside it, an end.

``gain``. A command is answered with a multiple of it: a → k·a.

``offset``. A constant is added to a command: a → a + b.

``limit``. A command is cut off at limits: a → clip(a, lower, upper).

It needs no memory, but it must come before what has some: firmware cuts a command off when it receives it, and
delays and lags follow the command that was cut off. A lag that follows the uncut command would take its time to come
back from where the robot never was. So it is the first of the filters. A servo's travel ends alike on both sides: one
magnitude then says both limits.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from sym2real.effects import truth
from sym2real.effects.body import Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, about_zero, of_any_body
from sym2real.effects.memory import Given, Memory, first_row
from sym2real.effects.searching import Searching, Shown, alone_on, by_role
from sym2real.effects.terms import scaled
from sym2real.layout import motors_of, turned_by_motors
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import UNLIMITED

LEAST, MOST = 0.2, 3.0  # what is likely


def _gain_substitute(equations: Equations, values: Values, body: Body) -> Equations:
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
    inject=truth.commanding(lambda command, _, values: command * values["value"]),
    substitute=_gain_substitute,
    columns="action",
    searching=Searching(
        why_not=alone_on("motors"),
        stood_for_by=_stood_for_by,
        shown_in=by_role({"speed": (Shown.SPEEDS,)}, ()),
    ),
)


def _inject(body: Body, values: Numbers) -> Change:
    if body.column in body.quantities:  # the thrust of motors, whose torques stay
        return truth.with_force(lambda data, _, known: truth.add_thrust(data, known["value"]))(body, values)
    return truth.commanding(lambda command, _, known: command + known["value"])(body, values)


OFFSET = Kind(
    name="offset",
    stage="command",
    parameters=about_zero(10),
    formula=r"a \to a + b",
    summary="The robot adds a constant to a command.",
    confused_with="a gain while the command hardly varies; for rate commands a torque bias or centre-of-mass offset",
    shown_by="commands of both signs, or of several sizes",
    fix="trim the actuator by minus this offset (a servo's centre, a thrust's trim), or subtract it from the command",
    inject=_inject,
    substitute=lambda equations, values, body: equations.substitute(
        {body.column: symbol(body.column) + values["value"]}
    ),
    columns="action",
    searching=Searching(
        why_not=alone_on("motors"),
        stood_for_by=by_role({"rate command": "torque_bias"}, ""),
        shown_in=by_role({"speed": (Shown.SPEEDS,), "steering": (Shown.BOTH_WAYS,)}, ()),
    ),
    by_torque=by_role({"rate command": True}, False),
)


# Quantiles of a command at which a plan cuts it off.
CUT_OFF = (0.99, 0.95, 0.9, 0.75, 0.5, 0.25)
QUANTILES = (0.5, 0.75, 0.9)
# A limit on both sides may lie from such a part of a command's mean size to such a part of its largest.
OF_MEAN, OF_LARGEST, CANDIDATES = 0.4, 0.8, 4
# Part of its largest value to one side that a command reaches to the other where its limits count as alike, and the
# units of what may: a servo's travel ends alike on both sides, so does a motor's current. A car's speed does not.
BOTH_WAYS, ALIKE = 0.5, frozenset({"rad", "rad/s", "N", "N m"})


def _one_of(body: Body) -> Body:
    """The body as an effect on its first motor sees it, where all motors have the same limit."""
    return body if body.column else replace(body, column=body.layouts.action.columns[0])


def _limit_parameters(body: Body) -> tuple[Parameter, ...]:
    body = _one_of(body)
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


def _clip(command: float, body: Body, values: Numbers) -> float:
    lower, upper = max(values["lower"], -values["magnitude"]), min(values["upper"], values["magnitude"])
    return float(np.clip(command, lower, upper))


def _end(body: Body, values: Array) -> str:
    """The end that logs reach: upper or lower; a magnitude of what ends alike on both sides and is sent to both."""
    up, down = (float((side * values).max(initial=0.0)) for side in (1.0, -1.0))
    if _one_of(body).unit in ALIKE and min(up, down) > BOTH_WAYS * max(up, down):
        return "magnitude"
    return "upper" if up >= down else "lower"


def _cut_at(body: Body, values: Array, quantiles: Sequence[float]) -> tuple[float, ...]:
    """Quantiles of a command, counted towards the end that it reaches, as far as they lie on that side of none."""
    side = -1.0 if _end(body, values) == "lower" else 1.0
    return tuple(side * level for level in np.quantile(side * values, quantiles).tolist() if level > 0)


def _between(sizes: Array) -> tuple[float, ...]:
    """A loop that knows no limit may ask for many times what it gets: from one to the other in equal factors."""
    mean, largest = float(sizes.mean()), float(sizes.max())
    return tuple(np.geomspace(OF_MEAN * mean, OF_LARGEST * largest, CANDIDATES).tolist()) if mean else ()


def _starts(body: Body, values: Array) -> tuple[float, ...]:
    """Where a limit may lie. A command that turns is often at its own ends, and no quantile lies between them."""
    if _end(body, values) == "magnitude":
        return _between(np.abs(values))
    towards = values[values < 0 if _end(body, values) == "lower" else values > 0]
    return _cut_at(body, towards, QUANTILES) if len(towards) else ()


def _fixed(body: Body, values: Array, _logs: Iterable[Trajectory]) -> tuple[str, ...]:
    """One end at a time."""
    return tuple(name for name in ("lower", "upper", "magnitude") if name != _end(body, values))


LIMIT = Kind(
    name="limit",
    stage="filter",
    parameters=_limit_parameters,
    formula=r"a \to \min(\max(a, a_\mathrm{lower}), a_\mathrm{upper}), |a| \le a_\mathrm{magnitude}",
    summary="A command beyond a limit is cut off at it.",
    confused_with="a gain below one, when most commands lie beyond the limit",
    shown_by="commands below and beyond the limit",
    fix="raise the limit in the actuator's firmware, or tell the controller about it",
    inject=truth.commanding(_clip),
    memory=lambda body: Memory(first_row, _cut),
    columns="action",
    of_all=lambda body: {*motors_of(body.layouts.action)} == {*body.layouts.action},
    contradiction=_contradiction,
    searching=Searching(
        why_not=alone_on("motors"),
        starts=_starts,
        from_null=False,
        fixed=_fixed,
        sizes=lambda body, values: _cut_at(body, values, CUT_OFF),
        shown_in=by_role({"speed": (Shown.SPEEDS,)}, ()),
    ),
)
