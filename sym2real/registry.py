"""A registry is a visible dict whose look-up failures name the nearest valid key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from sym2real.errors import ModelError, UnknownNameError

Value = TypeVar("Value")


class Registry(Mapping[str, Value]):
    """Mapping from a name that a user types to what it stands for.

    Args:
        kind: what the entries are, in the singular, for error messages ("robot").
        entries: the entries of this package; a user's own are added by :meth:`register`.

    Raises:
        UnknownNameError: on look-up of a name that is not there.
    """

    def __init__(self, kind: str, entries: Mapping[str, Value]) -> None:
        self.kind = kind
        self._entries = dict(entries)

    def __getitem__(self, name: str) -> Value:
        try:
            return self._entries[name]
        except KeyError:
            raise UnknownNameError(self.kind, name, self._entries) from None

    def register(self, name: str, entry: Value) -> None:
        """Add an entry of a user's own.

        Raises:
            ModelError: for a name that is taken.
        """
        if name in self._entries:
            raise ModelError(f"{self.kind} {name!r}: expected a name that is free, found one that is registered")
        self._entries[name] = entry

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)
