"""Numbers that a user gives as options: what each may be, checked as it is read, with errors for people.

A verb's field of one of these types is refused before any work; plain ``float`` fields take any finite number.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Annotated, Any, Literal

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from sym2real.errors import ModelError

MOST_SECONDS = 86400.0  # a day: no episode is longer
MOST_COUNT = 10**6  # of episodes, steps, rounds: more is a slip of the hand
MOST_SAMPLES = 2**20  # that MPPI draws
MOST_SEED = 2**63 - 1
MOST_COMMANDS = 100  # that a network sees: two seconds of a quadrotor's


def option(
    kind: type[Any],
    metavar: str,
    wanted: str,
    fits: Callable[[Any], bool] = lambda _: True,
    *,
    count: int = 1,
    words: Mapping[str, Any] = MappingProxyType({}),
) -> PrimitiveConstructorSpec[Any]:
    """How an option is read, which may also be left out where its field says so; numbers are finite.

    Args:
        kind: class of its value.
        metavar: stands for the value in the help.
        wanted: what it may be, for the error's words.
        fits: whether a value of that class will do.
        count: of values; more than one come as a tuple.
        words: that may stand in the place of a value, and what they mean.
    """

    def read(typed: str) -> Any:
        """The value of what was typed; ValueError for any other."""
        if typed in words:
            return words[typed]
        try:
            value = kind(typed)
        except ValueError:
            value = None
        if value is None or (kind is float and not math.isfinite(value)) or not fits(value):
            raise ValueError(f"expected {wanted}, found {typed!r}")
        return value

    return PrimitiveConstructorSpec(
        nargs=count,
        metavar=" ".join([metavar] * count),
        instance_from_str=lambda typed: read(typed[0]) if count == 1 else tuple(map(read, typed)),
        is_instance=lambda _: True,  # of defaults, which are this package's own
        str_from_instance=lambda value: list(map(str, value)) if isinstance(value, tuple) else [str(value)],
    )


def _whole(low: int, high: int) -> PrimitiveConstructorSpec[Any]:
    words = f"greater than 0 and at most {high}" if low else f"from 0 to {high}"
    return option(int, "INT", f"a whole number {words}", lambda value: low <= value <= high)


def number_of(text: str) -> float:
    """NaN for a text that is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def steps_in(seconds: float, dt: float) -> int:
    """Control periods of ``dt`` s in a time in s.

    Raises:
        ModelError: when that is none.
    """
    steps = round(seconds / dt)
    if steps < 1:
        raise ModelError(f"--seconds: expected at least one control period, {dt:g} s, found {seconds:g}")
    return steps


_positive = partial(option, float, "FLOAT", "a number greater than 0", lambda value: value > 0)
_SECONDS = option(
    float,
    "FLOAT",
    f"a number greater than 0 and at most {MOST_SECONDS:g}",
    lambda value: 0 < value <= MOST_SECONDS,
)
_COUNT = _whole(1, MOST_COUNT)

Positive = Annotated[float, _positive()]
OptionalPositive = Annotated[float | None, _positive()]
OptionalThreePositive = Annotated[tuple[float, float, float] | None, _positive(count=3)]
NotNegative = Annotated[float, option(float, "FLOAT", "a number that is not negative", lambda value: value >= 0)]
Seconds = Annotated[float, _SECONDS]
OptionalSeconds = Annotated[float | None, _SECONDS]
Count = Annotated[int, _COUNT]
OptionalCount = Annotated[int | None, _COUNT]
OptionalSamples = Annotated[
    int | None, _whole(1, MOST_SAMPLES), tyro.conf.arg(help="MPPI samples; the robot's own number by default.")
]
Seed = Annotated[int, _whole(0, MOST_SEED)]
Memory = Annotated[
    int | Literal["auto"],
    option(
        int,
        "auto|off|INT",
        f"auto, off or a whole number from 0 to {MOST_COMMANDS}",
        lambda value: 0 <= value <= MOST_COMMANDS,
        words={"auto": "auto", "off": 0},
    ),
]
