"""A registry is a visible dict whose look-up failures name the nearest valid key."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import TypeVar, cast

from sym2real.errors import ModelError, UnknownNameError

Value = TypeVar("Value")


@dataclass(frozen=True)
class _Later:
    at: str


class Registry(Mapping[str, Value]):
    """Mapping from a name that a user types to what it stands for.

    Args:
        kind: what the entries are, in the singular, for error messages ("robot").
        entries: the entries of this package; a user's own are added by :meth:`register`.
        later: entries that are imported when they are asked for, as ``module:attribute``.

    Raises:
        UnknownNameError: on look-up of a name that is not there.
    """

    def __init__(
        self, kind: str, entries: Mapping[str, Value], later: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self.kind = kind
        self._entries: dict[str, Value | _Later] = {**entries, **{name: _Later(at) for name, at in later.items()}}

    def __getitem__(self, name: str) -> Value:
        try:
            entry = self._entries[name]
        except KeyError:
            raise UnknownNameError(self.kind, name, self._entries) from None
        if isinstance(entry, _Later):
            module, _, attribute = entry.at.partition(":")
            entry = self._entries[name] = getattr(import_module(module), attribute)
        return cast("Value", entry)

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
