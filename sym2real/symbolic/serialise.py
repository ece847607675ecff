"""Equations ↔ JSON. The file is untrusted: expressions go through the safe parser, everything else is checked."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from sympy import Expr

from sym2real.errors import ModelError, Sym2RealError
from sym2real.layout import Field, Layout, Layouts
from sym2real.symbolic.expressions import text

if TYPE_CHECKING:
    from sym2real.symbolic.equations import Equations

FORMAT = "sym2real equations 1"
GROUPS = ("state", "action", "inputs")


def write_equations(equations: Equations) -> str:
    """Text of the equations; floats are written so that they read back exactly."""

    def written(expressions: Mapping[str, Expr]) -> dict[str, str]:
        return {name: text(expression) for name, expression in expressions.items()}

    content = {
        "format": FORMAT,
        "robot": equations.robot,
        "dt": equations.dt,
        "layouts": {group: [asdict(field) for field in getattr(equations.layouts, group).fields] for group in GROUPS},
        "next": written(equations.next),
        "output": written(equations.output),
        "quantities": written(equations.quantities),
        "parameters": dict(equations.parameters),
        "notes": list(equations.notes),
        "numbers": dict(equations.numbers),
        "filters": [{"effect": key, "values": written(values)} for key, values in equations.filters],
        "start": written(equations.start),
        "effects": [{"effect": key, "values": dict(values)} for key, values in equations.effects],
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_equations(source: str) -> dict[str, Any]:
    """What :func:`write_equations` wrote, as the arguments of ``Equations.parse``.

    Raises:
        ModelError: when the text is not such a JSON object; says which entry is wrong.
    """
    try:
        content = json.loads(source)
    except (ValueError, RecursionError) as error:
        raise ModelError(f"expected equations in JSON, found text that is not JSON: {error}") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        found = content.get("format") if isinstance(content, dict) else type(content).__name__
        raise ModelError(f"expected JSON of format {FORMAT!r}, found {found!r}")
    layouts = Layouts(*(_layout(content, group) for group in GROUPS))
    number = (int, float)
    return {
        "layouts": layouts,
        "equations": _mapping(content, "next", str),
        "dt": _entry(content, "dt", number),
        "output": _mapping(content, "output", str),
        "quantities": _mapping(content, "quantities", str),
        "parameters": _mapping(content, "parameters", number),
        "robot": _entry(content, "robot", str),
        "notes": _texts(content, "notes"),
        "numbers": _mapping(content, "numbers", number) if "numbers" in content else {},
        "filters": _effects(content, "filters", str) if "filters" in content else [],
        "start": _mapping(content, "start", str) if "start" in content else {},
        "effects": _effects(content, "effects", number) if "effects" in content else [],
    }


def _effects(content: Mapping[str, Any], key: str, kind: type | tuple[type, ...]) -> list[tuple[str, dict[str, Any]]]:
    entries = _entry(content, key, list)
    for entry in entries:
        if not isinstance(entry, dict):
            raise ModelError(f"equations in JSON: expected an effect and values under {key!r}, found {entry!r:.80}")
    return [(_entry(entry, "effect", str), _mapping(entry, "values", kind)) for entry in entries]


def _entry(content: Mapping[str, Any], key: str, kind: type | tuple[type, ...]) -> Any:
    value = content.get(key)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise ModelError(f"equations in JSON: expected another type of value under {key!r}, found {value!r:.80}")
    if isinstance(value, int | float) and not _is_finite(value):
        raise ModelError(f"equations in JSON: expected a finite number under {key!r}, found {value!r:.80}")
    return value


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number that no float holds
        return False


def _mapping(content: Mapping[str, Any], key: str, kind: type | tuple[type, ...]) -> dict[str, Any]:
    value: dict[str, Any] = _entry(content, key, dict)
    for name in value:
        _entry(value, name, kind)
    return value


def _texts(content: Mapping[str, Any], key: str) -> tuple[str, ...]:
    texts = _entry(content, key, list)
    for given in texts:
        if not isinstance(given, str):
            raise ModelError(f"equations in JSON: expected texts under {key!r}, found {given!r:.80}")
    return tuple(texts)


def _layout(content: Mapping[str, Any], group: str) -> Layout:
    fields = _entry(_entry(content, "layouts", dict), group, list)
    try:
        return Layout(tuple(map(Field.read, fields)))
    except Sym2RealError as error:
        raise ModelError(f"equations in JSON: layout {group!r} cannot be read: {error}") from error
