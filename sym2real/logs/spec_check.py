"""Checks the values of a TOML log specification; every error names the file, the key and the nearest valid one."""

import tomllib
from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from sym2real.errors import DataError, UnknownNameError, reason
from sym2real.field import is_name
from sym2real.logs.parts import ATTITUDES, ROWS_A_SECOND, Attitude, Source, TimeBase
from sym2real.logs.units import UNITS, factor
from sym2real.toml_tables import ROWS, TABLE, TEXT, Rule, checked, number, one_of, texts

UNIT_OF = {meant: one_of([name for name, (unit, _) in UNITS.items() if unit == meant]) for meant in ("s", "rad")}


def rules_of(kind: type, **special: Rule) -> dict[str, Rule]:
    """What may stand under the keys of a table: by the types of a dataclass, but for some."""
    return {name: _rule(hint) for name, hint in get_type_hints(kind).items()} | special


def _rule(hint: Any) -> Rule:
    parts = get_args(hint)
    if get_origin(hint) is Literal:
        return one_of(parts)
    if get_origin(hint) is tuple and (options := get_args(parts[0])):
        return texts(f"one of {', '.join(options)}, or both, in a list", options)
    if get_origin(hint) is tuple:
        return texts("a list of column names")
    return {str: TEXT, int: ROWS, float: number(), float | None: number()}.get(hint, TABLE)


OF_TIME = rules_of(TimeBase, unit=UNIT_OF["s"], rate=number(ROWS_A_SECOND))
SCALE, ZERO = number("a number > 0 (flip reverses a sign)"), number("a number", -inf)
OF_SOURCE = rules_of(Source, scale=SCALE, zero=ZERO)
OF_ATTITUDE = rules_of(Attitude, unit=UNIT_OF["rad"])


def keywords(kind: type, text: str, file: str | Path) -> dict[str, Any]:
    """Keyword arguments of the specification, a dataclass, that a text holds.

    Raises:
        DataError: naming the file, the key, what was expected and what was found.
    """
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DataError(file, "TOML", reason(error)) from None
    given = checked(file, values, rules_of(kind))
    given["time"] = _time(file, given.get("time", {}))
    given["columns"] = {name: _source(file, name, source) for name, source in given.get("columns", {}).items()}
    given |= {name: _attitude(file, name, given[name]) for name in ATTITUDES if name in given}
    _check_uses(file, given)
    return given


def _check_uses(file: str | Path, given: Mapping[str, Any]) -> None:
    """Refuse a column of the log that stands for two things, and remarks on one that stands for nothing."""
    uses = [(source.column, f"columns.{name}") for name, source in given["columns"].items()]
    uses += [(column, name) for name in ATTITUDES for column in given.get(name, Attitude()).sources]
    sources = [column for column, _ in uses]
    for key in ("flip", "hold"):
        for name in given.get(key, ()):
            if name not in sources:
                unknown = str(UnknownNameError("column", name, sources))
                raise DataError(file, f"in {key} a column that exists", unknown)
    uses += [(given["time"].column, "time.column")] if given["time"].column else []
    first: dict[str, str] = {}
    for column, use in uses:
        if column in first:
            raise DataError(file, "every column of the log once", f"{column!r} for {first[column]} and {use}")
        first[column] = use


def _time(file: str | Path, table: Mapping[str, Any]) -> TimeBase:
    found = TimeBase(**{"column": "" if "rate" in table else "t", **checked(file, table, OF_TIME, where="time.")})
    if bool(found.column) == (found.rate is not None):
        raise DataError(file, "in [time] either a column or a rate", "both" if found.column else "neither")
    return found


def _source(file: str | Path, name: str, value: object) -> Source:
    if not is_name(name):
        raise DataError(file, "in columns names of letters, digits and _", f"{name!r:.80}")
    if isinstance(value, str):
        return Source(value)
    if not isinstance(value, dict) or "column" not in value:
        raise DataError(file, f'{name} = "column" or {{ column = …, unit = … }}', repr(value), column=name)
    kind = f"key of column {name!r}"
    found = Source(**checked(file, value, OF_SOURCE, where=f"columns.{name}.", kind=kind))
    try:
        factor(found.unit, name)
    except UnknownNameError as error:
        raise DataError(file, "a unit that fits", str(error), column=name) from None
    return found


def _attitude(file: str | Path, name: str, table: Mapping[str, Any]) -> Attitude:
    found = Attitude(**checked(file, table, OF_ATTITUDE, where=f"{name}.", kind=f"key of [{name}]"))
    if (len(found.quaternion), len(found.euler)) not in {(4, 0), (0, 3)}:
        expected = f"in [{name}] either a quaternion of 4 columns or euler with 3 (roll, pitch, yaw)"
        raise DataError(file, expected, f"{len(found.quaternion)} and {len(found.euler)}")
    return found
