"""Answers as JSON holds them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any


def plain(value: Any) -> Any:
    """Lists for tuples, dictionaries for mappings, and what objects that have a ``to_dict`` make of themselves."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    return [plain(part) for part in value] if isinstance(value, tuple | list) else value


def fields_of(value: object, without: Collection[str] = ()) -> dict[str, Any]:
    """Attributes of an object by name, each as :func:`plain` makes it."""
    return {name: plain(part) for name, part in vars(value).items() if name not in without}
