"""Effects with their values as a user types them: ``wind fx=0.02 added_mass value=0.005``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from sym2real.errors import ModelError

if TYPE_CHECKING:
    from sym2real.effects import Effect
    from sym2real.effects.body import Describable


def chosen_effects(texts: Sequence[str], described: Describable) -> list[tuple[Effect, dict[str, float]]]:
    """Every effect with the values that follow its key.

    Args:
        texts: keys, ``KIND`` or ``KIND:COLUMN``, each followed by its ``PARAMETER=VALUE``.
        described: the robot or the equations that they are for.

    Raises:
        ModelError: when a value stands before the first key or is not a number.
        UnknownNameError: for a kind or column that does not exist.
    """
    from sym2real.effects import effect

    chosen: list[tuple[Effect, dict[str, float]]] = []
    for text in texts:
        if "=" not in text:
            chosen.append((effect(text, described), {}))
        elif chosen:
            name, value = split(text)
            chosen[-1][1][name] = number_of(name, value)
        else:
            raise ModelError(f"expected the name of an effect before its values, found {text!r}")
    return chosen


def split(text: str) -> tuple[str, str]:
    """PARAMETER=VALUE in its two parts."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise ModelError(f"expected PARAMETER=VALUE, found {text!r}")
    return name, value


def number_of(name: str, text: str) -> float:
    """The value of a parameter."""
    try:
        return float(text)
    except ValueError:
        raise ModelError(f"parameter {name!r}: expected a number, found {text!r}") from None
