"""Tables of TOML files, checked key by key: every error names file, key, what was expected and what was found."""

import sys
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sym2real.errors import DataError, UnknownNameError


@dataclass(frozen=True)
class Rule:
    """What may stand under a key.

    Args:
        wanted: it in words.
        fits: whether a value will do.
        kept: what is made of it.
    """

    wanted: str
    fits: Callable[[Any], bool]
    kept: Callable[[Any], Any] = lambda value: value


TEXT = Rule("a text", lambda value: isinstance(value, str))
TABLE = Rule("a table", lambda value: isinstance(value, dict))
SWITCH = Rule("true or false", lambda value: isinstance(value, bool))
ROWS = Rule("a whole number ≥ 0", lambda value: type(value) is int and value >= 0)


def number(wanted: str = "a number > 0", above: float = 0.0) -> Rule:
    """A number that a float holds, larger than another."""
    return Rule(wanted, lambda value: type(value) in {int, float} and above < value and _is_held(value), float)


def one_of(options: Collection[str]) -> Rule:
    """One of some texts."""
    return Rule(f"one of {', '.join(options)}", lambda value: value in [*options])


def texts(wanted: str, options: Collection[str] = ()) -> Rule:
    """A list of texts, of any or of those that there are."""
    return Rule(
        wanted,
        lambda value: (
            isinstance(value, list)
            and all(isinstance(text, str) and (not options or text in options) for text in value)
        ),
        tuple,
    )


def tables(wanted: str, least: int = 0) -> Rule:
    """A list of tables, at least so many."""
    return Rule(
        wanted,
        lambda value: (
            isinstance(value, list) and len(value) >= least and all(isinstance(entry, dict) for entry in value)
        ),
    )


def checked(
    file: str | Path,
    table: Mapping[str, Any],
    rules: Mapping[str, Rule],
    *,
    where: str = "",
    kind: str = "key",
    needed: Collection[str] = (),
) -> dict[str, Any]:
    """What a table holds, as its rules keep it.

    Args:
        file: that it is from.
        table: as it was read.
        rules: by key.
        where: stands before the key in errors ("time.").
        kind: what a key is called.
        needed: keys that must be there.

    Raises:
        DataError: for the first key that does not exist, is missing, or has a value that it cannot have.
    """
    if missing := [key for key in needed if key not in table]:
        raise DataError(file, f"{where}{missing[0]}, {rules[missing[0]].wanted}", f"no {missing[0]}")
    for key, value in table.items():
        if key not in rules:
            raise DataError(file, f"a {kind} that exists", str(UnknownNameError(kind, key, rules)))
        if not rules[key].fits(value):
            raise DataError(file, f"{where}{key} to be {rules[key].wanted}", f"{value!r:.80}")
    return {key: rules[key].kept(value) for key, value in table.items()}


def _is_held(value: float) -> bool:
    """Whether a float holds a number; TOML's integers have no end."""
    return abs(value) <= sys.float_info.max
