"""Things with their values as a user types them: ``wind fx=0.02 added_mass value=0.005``, ``circle speed=1 hover``."""

import math
from collections.abc import Callable, Sequence

from sym2real.cli.numbers import number_of
from sym2real.errors import ModelError


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
