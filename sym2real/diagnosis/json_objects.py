"""Answers as JSON holds them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import is_dataclass
from typing import Any


def plain(value: Any) -> Any:
    """Lists for tuples, dictionaries for mappings and plain objects, and what a ``to_dict`` makes of others."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if is_dataclass(value):
        return fields_of(value)
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    return [plain(part) for part in value] if isinstance(value, tuple | list) else value


def fields_of(value: object, without: Collection[str] = ()) -> dict[str, Any]:
    """Attributes of an object by name, each as :func:`plain` makes it."""
    return {name: plain(part) for name, part in vars(value).items() if name not in without}
