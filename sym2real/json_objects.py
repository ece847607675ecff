"""Values as JSON holds them."""

import math
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any


def plain(value: Any) -> Any:
    """Lists for tuples, dictionaries for mappings and plain objects, and what a ``to_dict`` makes of others.

    A number that JSON lacks (NaN, infinity) becomes null, a path its text.
    """
    value = value.tolist() if hasattr(value, "tolist") else value  # NumPy's
    if hasattr(value, "to_dict"):
        return plain(value.to_dict())
    if is_dataclass(value):
        return fields_of(value)
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list):
        return [plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def fields_of(value: Any, without: Collection[str] = ()) -> dict[str, Any]:
    """Fields of a dataclass's object by name, each as :func:`plain` makes it."""
    names = (field.name for field in fields(value) if field.name not in without)
    return {name: plain(getattr(value, name)) for name in names}
