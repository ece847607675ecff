"""Tables of TOML files as dataclasses, whose annotations say what may stand under a key.

Every error names file, key, what was expected and what was found.
"""

import math
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import msgspec

from sym2real.errors import DataError, UnknownNameError

Kind = TypeVar("Kind")
# What msgspec calls kinds of values, in the words of a user.
WORDS = {"float": "a number", "int": "a whole number", "str": "a text", "bool": "true or false", "object": "a table",
         "array": "a list", " | null": "", "Number out of range": "a finite number"}  # fmt: skip
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
Count = Annotated[int, msgspec.Meta(ge=0)]


def of_kind(file: str | Path, table: Mapping[str, Any], kind: type[Kind], *, where: str = "", key: str = "key") -> Kind:
    """An object of a dataclass from a table, and from the tables in it.

    Args:
        file: that it is from.
        table: as it was read.
        kind: the dataclass; fields without a default must be there.
        where: stands before the key in errors ("time.").
        key: what a key is called.

    Raises:
        DataError: for the first key that does not exist, is missing, or has a value that it cannot have.
    """
    hints, needed = get_type_hints(kind, include_extras=True), []
    for field in fields(kind):  # type: ignore[arg-type]
        needed += [field.name] if field.default is field.default_factory is MISSING else []
    if missing := [name for name in needed if name not in table]:
        raise DataError(file, f"{where}{missing[0]}", f"no {missing[0]}")
    for name in table:
        if name not in hints:
            raise DataError(file, f"a {key} that exists", str(UnknownNameError(key, name, hints)))
    return kind(**{name: _converted(file, value, hints[name], f"{where}{name}") for name, value in table.items()})


def _converted(file: str | Path, value: Any, hint: Any, place: str) -> Any:
    inside = get_args(hint)
    if isinstance(hint, type) and is_dataclass(hint) and isinstance(value, Mapping):
        return of_kind(file, value, hint, where=f"{place}.", key=f"key of {place}")
    if get_origin(hint) is Mapping and is_dataclass(inside[1]) and isinstance(value, Mapping):
        return {name: _converted(file, part, inside[1], f"{place}.{name}") for name, part in value.items()}
    try:
        made = msgspec.convert(value, hint)
    except msgspec.ValidationError as error:
        raise DataError(file, f"{place} to be {_wanted(hint, str(error))}", f"{value!r:.80}") from None
    if isinstance(made, float) and not math.isfinite(made):
        raise DataError(file, f"{place} to be a finite number", f"{value!r}")
    return made


def _wanted(hint: Any, message: str) -> str:
    literal = next((kind for kind in (hint, *get_args(hint)) if get_origin(kind) is Literal), None)
    if literal is not None:
        return f"one of {', '.join(get_args(literal))}"
    wanted = message.removeprefix("Expected ").partition(", got")[0].partition(" - at")[0].replace("`", "")
    for name, words in WORDS.items():
        wanted = wanted.replace(name, words)
    return wanted
