"""Effects with their values as a user types them: ``wind fx=0.02 added_mass value=0.005``."""

import math
from collections.abc import Mapping, Sequence

from rich.console import Console

from sym2real.cli.typed_values import with_values
from sym2real.effects import Effect, catalogue
from sym2real.effects.body import Describable
from sym2real.effects.kind import UNLIMITED, Parameter
from sym2real.errors import ModelError


def chosen_effects(texts: Sequence[str], described: Describable) -> list[tuple[Effect, dict[str, float]]]:
    """Every effect with the values that follow its key.

    Args:
        texts: keys, ``KIND`` or ``KIND:COLUMN``, each followed by its ``PARAMETER=VALUE``.
        described: the robot or the equations that they are for.

    Raises:
        ModelError: when a value stands before the first key or is not a number, or an effect does not apply or is named
            twice.
        UnknownNameError: for a kind or column that does not exist.
    """

    def parameter_of(key: str) -> str:
        return catalogue.effect(key, described).parameters[0].name

    named = with_values(texts, "the name of an effect", parameter_of)
    keys = [key for key, _ in named]
    for key in keys:
        if keys.count(key) > 1:
            raise ModelError(f"{key}: expected once with all its values behind it, found {keys.count(key)} times")
    chosen = [(catalogue.effect(key, described), values) for key, values in named]
    for chosen_effect, _ in chosen:
        if reason := catalogue.refusal(chosen_effect, described):
            raise ModelError(reason)
    return chosen


def require_values(chosen: Sequence[tuple[Effect, Mapping[str, float]]], otherwise: str = "") -> None:
    """Refuse effects without a value, which would change nothing.

    Args:
        chosen: effects with their values.
        otherwise: what else the user can give, for the error's words.

    Raises:
        ModelError: with the parameters that an effect has, their units and bounds.
    """
    for effect, values in chosen:
        if not values:
            known = "; ".join(f"{parameter.name}=… {_unit_and_bounds(parameter)}" for parameter in effect.parameters)
            raise ModelError(f"{effect.key}: expected a value ({known}){otherwise}, found none")


def warn_of_values(chosen: Sequence[tuple[Effect, Mapping[str, float]]], console: Console) -> None:
    """A line per value outside the bounds that the catalogue gives it for this robot; impossible ones are errors."""
    for effect, values in chosen:
        for parameter in effect.parameters:
            value = values.get(parameter.name, math.nan)
            if value in parameter.domain and not parameter.low <= value <= parameter.high:
                text = f"{effect.key} {parameter.name}={value:g} is outside what is likely here"
                console.print(f"warning: {text}: {_unit_and_bounds(parameter)}", markup=False)


def _unit_and_bounds(parameter: Parameter) -> str:
    unit = "without unit," if parameter.unit == "1" else f"in {parameter.unit},"
    bounds = [
        f"{word} {bound:.3g}"
        for word, bound in (("from", parameter.low), ("to", parameter.high))
        if abs(bound) < UNLIMITED
    ]
    return " ".join((unit, *bounds))
