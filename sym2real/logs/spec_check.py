"""Checks the values of a TOML log specification; every error names the file, the key and the nearest valid one."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any

from sym2real.errors import DataError, UnknownNameError, reason
from sym2real.field import is_name
from sym2real.logs.parts import (
    ATTITUDES,
    DERIVED,
    DIRECTIONS,
    FRAMES,
    ORDERS,
    VELOCITY_FRAMES,
    Attitude,
    Source,
    TimeBase,
)
from sym2real.logs.units import UNITS, factor

LARGEST = sys.float_info.max


class SpecChecker:
    """Turns the values of a TOML file into a specification; every error names the file."""

    def __init__(self, file: str | Path) -> None:
        self.file = file

    def keywords(self, text: str, known: Mapping[str, Any]) -> dict[str, Any]:
        """Keyword arguments of the specification whose fields are ``known``.

        Raises:
            DataError: naming the file, the key, what was expected and what was found.
        """
        try:
            values = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise DataError(self.file, "TOML", reason(error)) from None
        self._keys("key", values, known)
        keywords: dict[str, Any] = dict(values)
        keywords["time"] = self._time(self._table(values, "time"))
        keywords["columns"] = {
            name: self._source(name, source) for name, source in self._table(values, "columns").items()
        }
        keywords |= {name: self._attitude(name, self._table(values, name)) for name in ATTITUDES if name in values}
        keywords["header"] = self._texts("header", values.get("header", []))
        keywords["flip"] = self._texts("flip", values.get("flip", []))
        keywords["hold"] = self._texts("hold", values.get("hold", []))
        keywords["derive"] = self._texts("derive", values.get("derive", []))
        for name in ("drop_first", "drop_last"):
            self._typed(name, values.get(name, 0), int, lambda rows: rows >= 0, "a whole number ≥ 0")
        for name in ("name", "title"):
            self._typed(name, values.get(name, ""), str)
        keywords["mass"] = self._number("mass", values.get("mass", 1.0))
        for value in keywords["derive"]:
            self._one_of("derive", value, DERIVED)
        self._one_of("velocity_frame", values.get("velocity_frame", "world"), VELOCITY_FRAMES)
        self._one_of("frames", values.get("frames", "z_up"), FRAMES)
        self._units(keywords["columns"])
        self._flips(keywords)
        self._once(keywords)
        return keywords

    def _once(self, keywords: Mapping[str, Any]) -> None:
        """Refuse a column of the log that stands for two things."""
        uses = [(source.column, f"columns.{name}") for name, source in keywords["columns"].items()]
        uses += [(keywords["time"].column, "time.column")] if keywords["time"].column else []
        for name in ATTITUDES:
            uses += [(column, name) for column in keywords.get(name, Attitude()).sources]
        first: dict[str, str] = {}
        for column, use in uses:
            if column in first:
                raise DataError(self.file, "every column of the log once", f"{column!r} for {first[column]} and {use}")
            first[column] = use

    def _time(self, values: Mapping[str, Any]) -> TimeBase:
        self._keys("key of [time]", values, TimeBase.__dataclass_fields__)
        self._one_of("time.unit", values.get("unit", "s"), [name for name in UNITS if UNITS[name][0] == "s"])
        numbers = {name: self._number(f"time.{name}", values[name]) for name in ("rate", "dt") if name in values}
        column = self._typed("time.column", values.get("column", "" if "rate" in values else "t"), str)
        if bool(column) == ("rate" in values):
            raise DataError(self.file, "in [time] either a column or a rate", "both" if column else "neither")
        return TimeBase(column, values.get("unit", "s"), numbers.get("rate"), numbers.get("dt"))

    def _source(self, name: str, value: object) -> Source:
        if not is_name(name):
            raise DataError(self.file, "in columns names of letters, digits and _", f"{name!r:.80}")
        if isinstance(value, str):
            return Source(value)
        if not isinstance(value, dict) or "column" not in value:
            raise DataError(self.file, f'{name} = "column" or {{ column = …, unit = … }}', repr(value), column=name)
        self._keys(f"key of column {name!r}", value, Source.__dataclass_fields__)
        texts = {
            key: self._typed(f"columns.{name}.{key}", value[key], str) for key in ("column", "unit") if key in value
        }
        scale = self._number(f"columns.{name}.scale", value.get("scale", 1.0), "a number > 0 (flip reverses a sign)")
        zero = self._number(f"columns.{name}.zero", value.get("zero", 0.0), "a number", -inf)
        return Source(**texts, scale=scale, zero=zero)

    def _attitude(self, name: str, values: Mapping[str, Any]) -> Attitude:
        self._keys(f"key of [{name}]", values, Attitude.__dataclass_fields__)
        self._one_of(f"{name}.order", values.get("order", "wxyz"), ORDERS)
        self._one_of(f"{name}.direction", values.get("direction", "body_to_world"), DIRECTIONS)
        self._one_of(f"{name}.unit", values.get("unit", "rad"), [unit for unit in UNITS if UNITS[unit][0] == "rad"])
        quaternion = self._texts(f"{name}.quaternion", values.get("quaternion", []))
        euler = self._texts(f"{name}.euler", values.get("euler", []))
        if (len(quaternion), len(euler)) not in {(4, 0), (0, 3)}:
            expected = f"in [{name}] either a quaternion of 4 columns or euler with 3 (roll, pitch, yaw)"
            raise DataError(self.file, expected, f"{len(quaternion)} and {len(euler)}")
        return Attitude(**{**values, "quaternion": quaternion, "euler": euler})

    def _flips(self, keywords: Mapping[str, Any]) -> None:
        sources = [source.column for source in keywords["columns"].values()]
        for name in ATTITUDES:
            sources += keywords.get(name, Attitude()).sources
        for key in ("flip", "hold"):
            self._named(key, keywords[key], sources)

    def _units(self, columns: Mapping[str, Source]) -> None:
        for name, source in columns.items():
            try:
                factor(source.unit, name)
            except UnknownNameError as error:
                raise DataError(self.file, "a unit that fits", str(error), column=name) from None

    def _keys(self, kind: str, values: Mapping[str, Any], known: Mapping[str, Any]) -> None:
        for name in values:
            if name not in known:
                raise DataError(self.file, f"a {kind} that exists", str(UnknownNameError(kind, name, known)))

    def _named(self, key: str, names: Any, known: Any) -> None:
        for name in names:
            if name not in known:
                raise DataError(
                    self.file, f"in {key} a column that exists", str(UnknownNameError("column", name, known))
                )

    def _one_of(self, key: str, value: object, options: Any) -> None:
        if value not in options:
            raise DataError(self.file, f"{key} to be one of {', '.join(options)}", repr(value))

    def _table(self, values: Mapping[str, Any], key: str) -> Mapping[str, Any]:
        table: Mapping[str, Any] = self._typed(key, values.get(key, {}), dict)
        return table

    def _texts(self, key: str, values: object) -> tuple[str, ...]:
        if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
            raise DataError(self.file, f"{key} to be a list of column names", repr(values))
        return tuple(values)

    def _number(self, key: str, value: object, wanted: str = "a number > 0", low: float = 0.0) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not low < value <= LARGEST:
            raise DataError(self.file, f"{key} to be {wanted}", f"{value!r:.80}")
        return float(value)

    def _typed(self, key: str, value: Any, kind: type, holds: Any = None, wanted: str = "") -> Any:
        if not isinstance(value, kind) or isinstance(value, bool) or (holds is not None and not holds(value)):
            raise DataError(self.file, f"{key} to be {wanted or kind.__name__}", repr(value))
        return value
