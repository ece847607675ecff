"""Numbers that a user gives as options: what each may be, checked as it is read, with errors for people.

A verb's field of one of these types is refused before any work; plain ``float`` fields take any finite number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal

from tyro.constructors import PrimitiveConstructorSpec

from sym2real.errors import ModelError

MOST_SECONDS = 86400.0  # a day: no episode is longer
MOST_COUNT = 10**6  # of episodes, steps, rounds: more is a slip of the hand
MOST_SAMPLES = 2**20  # that MPPI draws
MOST_SEED = 2**63 - 1
MOST_COMMANDS = 100  # that a network sees: two seconds of a quadrotor's


def option(
    kind: type[Any], metavar: str, wanted: str, *, optional: bool, fits: Callable[[Any], bool] = lambda _: True
) -> PrimitiveConstructorSpec[Any]:
    """How an option is read; numbers are finite.

    Args:
        kind: class of its value.
        metavar: stands for the value in the help.
        wanted: what it may be, for the error's words.
        optional: whether it may be left out.
        fits: whether a value of that class will do.
    """

    def read(typed: list[str]) -> Any:
        """The value of what was typed; ValueError for any other."""
        try:
            value = kind(typed[0])
        except ValueError:
            value = None
        if value is None or (kind is float and not math.isfinite(value)) or not fits(value):
            raise ValueError(f"expected {wanted}, found {typed[0]!r}")
        return value

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=read,
        is_instance=lambda value: isinstance(value, kind) or (optional and value is None),
        str_from_instance=lambda value: [str(value)],
    )


def _positive(optional: bool) -> PrimitiveConstructorSpec[Any]:
    return option(float, "FLOAT", "a number greater than 0", optional=optional, fits=lambda value: value > 0)


def _seconds(optional: bool) -> PrimitiveConstructorSpec[Any]:
    wanted = f"a number greater than 0 and at most {MOST_SECONDS:g}"
    return option(float, "FLOAT", wanted, optional=optional, fits=lambda value: 0 < value <= MOST_SECONDS)


def _count(optional: bool, most: int = MOST_COUNT) -> PrimitiveConstructorSpec[Any]:
    wanted = f"a whole number greater than 0 and at most {most}"
    return option(int, "INT", wanted, optional=optional, fits=lambda value: 0 < value <= most)


def _three_positive(optional: bool) -> PrimitiveConstructorSpec[Any]:
    constructor = _positive(optional=False)
    return PrimitiveConstructorSpec(
        nargs=3,
        metavar="FLOAT FLOAT FLOAT",
        instance_from_str=lambda typed: tuple(constructor.instance_from_str([text]) for text in typed),
        is_instance=lambda value: isinstance(value, tuple) or (optional and value is None),
        str_from_instance=lambda values: ["None"] if values is None else [str(value) for value in values],
    )


def _memory() -> PrimitiveConstructorSpec[Any]:
    constructor = option(
        int,
        "INT",
        f"auto, off or a whole number from 0 to {MOST_COMMANDS}",
        optional=False,
        fits=lambda value: 0 <= value <= MOST_COMMANDS,
    )
    words: dict[str, Any] = {"auto": "auto", "off": 0}
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="auto|off|INT",
        instance_from_str=lambda typed: words[typed[0]] if typed[0] in words else constructor.instance_from_str(typed),
        is_instance=lambda value: value == "auto" or isinstance(value, int),
        str_from_instance=lambda value: [str(value)],
    )


def steps_in(seconds: float, dt: float) -> int:
    """Control periods of ``dt`` s in a time in s.

    Raises:
        ModelError: when that is none.
    """
    steps = round(seconds / dt)
    if steps < 1:
        raise ModelError(f"--seconds: expected at least one control period, {dt:g} s, found {seconds:g}")
    return steps


Positive = Annotated[float, _positive(optional=False)]
OptionalPositive = Annotated[float | None, _positive(optional=True)]
ThreePositive = Annotated[tuple[float, float, float], _three_positive(optional=False)]
OptionalThreePositive = Annotated[tuple[float, float, float] | None, _three_positive(optional=True)]
NotNegative = Annotated[
    float, option(float, "FLOAT", "a number that is not negative", optional=False, fits=lambda value: value >= 0)
]
Seconds = Annotated[float, _seconds(optional=False)]
OptionalSeconds = Annotated[float | None, _seconds(optional=True)]
Count = Annotated[int, _count(optional=False)]
OptionalCount = Annotated[int | None, _count(optional=True)]
OptionalSamples = Annotated[int | None, _count(optional=True, most=MOST_SAMPLES)]
OptionalRound = Annotated[
    int | None,
    option(int, "INT", "a whole number from 0 on", optional=True, fits=lambda value: value >= 0),
]
Seed = Annotated[
    int,
    option(
        int,
        "INT",
        f"a whole number from 0 to {MOST_SEED}",
        optional=False,
        fits=lambda value: 0 <= value <= MOST_SEED,
    ),
]
Memory = Annotated[int | Literal["auto"], _memory()]
