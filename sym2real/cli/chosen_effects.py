"""Things with their values as a user types them: ``wind fx=0.02 added_mass value=0.005``, ``circle speed=1 hover``."""

import math
from collections.abc import Callable, Mapping, Sequence

from sym2real.cli.numbers import number_of
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


def beyond_bounds(chosen: Sequence[tuple[Effect, Mapping[str, float]]]) -> list[str]:
    """One line per value outside the bounds that the catalogue gives it for this robot; impossible ones are errors."""
    return [
        f"{effect.key} {parameter.name}={values[parameter.name]:g} is outside what is likely here: "
        f"{_unit_and_bounds(parameter)}"
        for effect, values in chosen
        for parameter in effect.parameters
        if parameter.name in values
        and values[parameter.name] in parameter.domain
        and not parameter.low <= values[parameter.name] <= parameter.high
    ]


def _unit_and_bounds(parameter: Parameter) -> str:
    unit = "without unit," if parameter.unit == "1" else f"in {parameter.unit},"
    bounds = [
        f"{word} {bound:.3g}"
        for word, bound in (("from", parameter.low), ("to", parameter.high))
        if abs(bound) < UNLIMITED
    ]
    return " ".join((unit, *bounds))


def with_values(
    texts: Sequence[str], what: str, parameter_of: Callable[[str], str] = lambda _: "OPTION"
) -> list[tuple[str, dict[str, float]]]:
    """Every name with the values that follow it.

    Args:
        texts: names, each followed by its ``PARAMETER=VALUE``.
        what: a name is the name of, for the error's words.
        parameter_of: the parameter that a number after a name may have been meant for.

    Raises:
        ModelError: when a value stands before the first name, without its parameter, is given twice or is not a number.
    """
    chosen: list[tuple[str, dict[str, float]]] = []
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals and chosen and not math.isnan(number_of(text)):
            key = chosen[-1][0]
            raise ModelError(f"expected `{key} {parameter_of(key)}={text}`, found {text!r} alone")
        if not equals:
            chosen.append((text, {}))
        elif not name:
            raise ModelError(f"expected PARAMETER=VALUE, found {text!r}")
        elif chosen:
            key, values = chosen[-1]
            if name in values:
                raise ModelError(f"{key}: expected {name} once, found {name}={values[name]:g} and {text}")
            values[name] = number = number_of(value)
            if not math.isfinite(number):
                raise ModelError(f"parameter {name!r}: expected a number, found {value!r}")
        else:
            raise ModelError(f"expected {what} before its values, found {text!r}")
    return chosen
