"""Checks what a TOML log specification says as a whole; every error names the file and the key."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sym2real.errors import DataError, UnknownNameError, reason
from sym2real.field import is_name
from sym2real.logs.parts import ATTITUDES
from sym2real.logs.units import factor
from sym2real.toml_tables import of_kind

if TYPE_CHECKING:
    from sym2real.logs.specification import LogSpec


def specification_of(kind: type[LogSpec], text: str, file: str | Path) -> LogSpec:
    """The specification that a text holds.

    Raises:
        DataError: naming the file, the key, what was expected and what was found.
    """
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DataError(file, "TOML", reason(error)) from None
    if isinstance(table.get("columns"), dict):
        table["columns"] = {name: _source(file, name, value) for name, value in table["columns"].items()}
    if isinstance(time := table.get("time"), dict) and "rate" in time:
        time.setdefault("column", "")
    spec = of_kind(file, table, kind)
    if bool(spec.time.column) == (spec.time.rate is not None):
        raise DataError(file, "in [time] either a column or a rate", "both" if spec.time.column else "neither")
    for name, source in spec.columns.items():
        try:
            factor(source.unit, name)
        except UnknownNameError as error:
            raise DataError(file, "a unit that fits", str(error), column=name) from None
    for name in (name for name in ATTITUDES if name in table):
        attitude = getattr(spec, name)
        if (len(attitude.quaternion), len(attitude.euler)) not in {(4, 0), (2, 0), (0, 3)}:
            expected = f"in [{name}] a quaternion of 4 columns, or of 2 (w, z), or euler with 3 (roll, pitch, yaw)"
            raise DataError(file, expected, f"{len(attitude.quaternion)} and {len(attitude.euler)}")
    _check_uses(file, spec)
    return spec


def _source(file: str | Path, name: str, value: object) -> Mapping[str, Any]:
    """The table of a column; a text alone names the column of the log."""
    if not is_name(name):
        raise DataError(file, "in columns names of letters, digits and _", f"{name!r:.80}")
    if isinstance(value, str):
        return {"column": value}
    if not isinstance(value, dict) or "column" not in value:
        raise DataError(file, f'{name} = "column" or {{ column = …, unit = … }}', repr(value), column=name)
    return value


def _check_uses(file: str | Path, spec: LogSpec) -> None:
    """Refuse a column of the log that stands for two things, and remarks on one that stands for nothing."""
    uses = [(source.column, f"columns.{name}") for name, source in spec.columns.items()]
    uses += [(column, name) for name in ATTITUDES for column in getattr(spec, name).sources]
    sources = [column for column, _ in uses]
    for key in ("flip", "hold"):
        for name in getattr(spec, key):
            if name not in sources:
                raise DataError(file, f"in {key} a column that exists", str(UnknownNameError("column", name, sources)))
    uses += [(spec.time.column, "time.column")] if spec.time.column else []
    first: dict[str, str] = {}
    for column, use in uses:
        if column in first:
            raise DataError(file, "every column of the log once", f"{column!r} for {first[column]} and {use}")
        first[column] = use
