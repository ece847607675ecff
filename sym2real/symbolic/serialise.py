"""Equations ↔ JSON. The file is untrusted: expressions go through the safe parser, everything else is checked."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

import msgspec
from sympy import Expr

from sym2real.errors import ModelError
from sym2real.field import Group
from sym2real.layout import Layouts
from sym2real.symbolic.expressions import text

if TYPE_CHECKING:
    from sym2real.symbolic.equations import Equations

FORMAT = "sym2real equations 1"


def write_equations(equations: Equations) -> str:
    """Text of the equations; floats are written so that they read back exactly."""

    def written(expressions: Mapping[str, Expr]) -> dict[str, str]:
        return {name: text(expression) for name, expression in expressions.items()}

    content = {
        "format": FORMAT,
        "robot": equations.robot,
        "dt": equations.dt,
        "layouts": equations.layouts.to_dict(),
        "next": written(equations.next),
        "output": written(equations.output),
        "quantities": written(equations.quantities),
        "parameters": dict(equations.parameters),
        "notes": list(equations.notes),
        "numbers": dict(equations.numbers),
        "filters": [{"effect": key, "values": written(values)} for key, values in equations.filters],
        "start": written(equations.start),
        "effects": [{"effect": key, "values": dict(values)} for key, values in equations.effects],
        **({} if equations.origin is None else {"origin": msgspec.to_builtins(equations.origin)}),
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


Values = TypeVar("Values")


class Origin(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A robot from an MJCF, as :func:`sym2real.robots.from_mjcf.from_mjcf` makes it again.

    Args:
        mjcf: the description, which needs no file beside it.
        name: of the robot.
        title: what people call it.
        actions: every actuator that is commanded, and its column.
        state: columns of the state.
        dt: control period in s.
        numbers: of the robot by name, SI units.
    """

    mjcf: str
    name: str
    title: str
    actions: tuple[tuple[str, str], ...]
    state: tuple[str, ...]
    dt: float
    numbers: tuple[tuple[str, float], ...]


class Chosen(msgspec.Struct, Generic[Values], forbid_unknown_fields=True):
    """An effect and its values by parameter."""

    effect: str
    values: dict[str, Values]


class Written(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of equations holds."""

    format: Literal["sym2real equations 1"]
    robot: str
    dt: float
    layouts: dict[Group, list[dict[str, Any]]]
    next: dict[str, str]
    output: dict[str, str]
    quantities: dict[str, str]
    parameters: dict[str, float]
    notes: tuple[str, ...]
    numbers: dict[str, float] = {}
    filters: tuple[Chosen[str], ...] = ()
    start: dict[str, str] = {}
    effects: tuple[Chosen[float], ...] = ()
    origin: Origin | None = None


# Made ahead of any thread: msgspec takes a class apart when it first meets it, and no two threads may at once.
DECODER = msgspec.json.Decoder(Written)


def read_equations(source: str) -> dict[str, Any]:
    """What :func:`write_equations` wrote, as the arguments of ``Equations.parse``.

    Raises:
        ModelError: when the text is not such a JSON object; says which entry is wrong.
    """
    try:
        decoded = DECODER.decode(source)
        layouts = Layouts.from_dict(decoded.layouts)
    except (KeyError, ValueError, RecursionError) as error:
        raise ModelError(f"expected equations in JSON of format {FORMAT!r}, found another text: {error}") from error
    same = ("dt", "output", "quantities", "parameters", "robot", "notes", "numbers", "start", "origin")
    return {
        "layouts": layouts,
        "equations": decoded.next,
        "filters": [(chosen.effect, chosen.values) for chosen in decoded.filters],
        "effects": [(chosen.effect, chosen.values) for chosen in decoded.effects],
        **{name: getattr(decoded, name) for name in same},
    }
