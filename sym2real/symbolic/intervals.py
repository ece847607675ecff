"""Bounds of every value of a straight-line program, from bounds of its inputs (interval arithmetic).

What is proved here need not be checked where the program runs: the argument of a sine that stays within a few turns
needs no range reduction.
Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009, ch. 2 and 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from sym2real.symbolic.program import Program


class Interval(NamedTuple):
    """All numbers from ``low`` to ``high``; infinite where nothing is known."""

    low: float
    high: float

    @property
    def magnitude(self) -> float:
        """Largest absolute value."""
        return max(abs(self.low), abs(self.high))


EVERYTHING = Interval(-math.inf, math.inf)
TRUTH = Interval(0.0, 1.0)
SINGLE = 1e-6  # relative error of a few operations in single precision


def bounds(program: Program, inputs: Mapping[str, Interval], longest_reciprocal: float = math.inf) -> list[Interval]:
    """Interval of every value, in the order of their numbers; inputs that are not given may be anything.

    Args:
        program: what is computed.
        inputs: what is known of its inputs, by name.
        longest_reciprocal: assumed bound of every reciprocal square root (the normalisation of a near-unit vector).
    """
    found = [inputs.get(name, EVERYTHING) for name in program.inputs]
    found += [Interval(constant, constant) for constant in program.constants]
    for operation, operands in program.instructions:
        given = [found[operand] for operand in operands]
        if operation == "multiply" and operands[0] == operands[1]:
            found.append(_square(given[0]))
        elif operation == "rsqrt":
            known = RULES[operation](*given)
            found.append(Interval(known.low, min(known.high, longest_reciprocal)))
        else:
            found.append(_checked(RULES[operation](*given)))
    return found


def _checked(interval: Interval) -> Interval:
    """Nothing is known where a bound is not a number (0 · ∞, ∞ - ∞)."""
    low = -math.inf if math.isnan(interval.low) else interval.low
    high = math.inf if math.isnan(interval.high) else interval.high
    return Interval(low, high)


def _hull(values: Sequence[float]) -> Interval:
    return EVERYTHING if any(map(math.isnan, values)) else Interval(min(values), max(values))


def _square(a: Interval) -> Interval:
    inside = a.low <= 0.0 <= a.high
    return Interval(0.0 if inside else min(a.low**2, a.high**2), a.magnitude**2)


def _multiply(a: Interval, b: Interval) -> Interval:
    # 0 · ∞ is 0 here: an interval holds finite numbers only.
    return _hull([0.0 if 0.0 in (x, y) else x * y for x in a for y in b])


def _reciprocal(a: Interval) -> Interval:
    if a.low <= 0.0 <= a.high:
        return EVERYTHING
    return Interval(1.0 / a.high, 1.0 / a.low)


def _power(a: Interval, b: Interval) -> Interval:
    if a.low <= 0.0 or math.inf in (a.high, b.magnitude):
        return EVERYTHING
    try:
        return _hull([x**y for x in a for y in b])
    except OverflowError:
        return Interval(0.0, math.inf)


def _sine(a: Interval) -> Interval:
    """Extremes are at the ends, and ±1 where a quarter turn of that sign lies between them."""
    if not a.high - a.low < 2.0 * math.pi:
        return Interval(-1.0, 1.0)
    ends = [math.sin(a.low), math.sin(a.high)]
    peak = 2.0 * math.pi * math.ceil((a.low - 0.5 * math.pi) / (2.0 * math.pi)) + 0.5 * math.pi <= a.high
    trough = 2.0 * math.pi * math.ceil((a.low + 0.5 * math.pi) / (2.0 * math.pi)) - 0.5 * math.pi <= a.high
    return Interval(-1.0 if trough else min(ends), 1.0 if peak else max(ends))


def _cosine(a: Interval) -> Interval:
    return _sine(Interval(a.low + 0.5 * math.pi, a.high + 0.5 * math.pi))


def _root(a: Interval) -> Interval:
    return Interval(math.sqrt(max(a.low, 0.0)), math.sqrt(max(a.high, 0.0)))


def _rising(function: Callable[[float], float], low: float = -math.inf) -> Callable[[Interval], Interval]:
    """Rule of a function that never falls and is defined from ``low`` on."""

    def apply(a: Interval) -> Interval:
        if a.low < low:
            return EVERYTHING
        try:
            return Interval(function(a.low), function(a.high))
        except (OverflowError, ValueError):
            return EVERYTHING

    return apply


def _rounded(function: Callable[[float], int]) -> Callable[[Interval], Interval]:
    """Rule of rounding to whole numbers, of an argument that has been rounded to single precision before."""

    def apply(a: Interval) -> Interval:
        if not math.isfinite(a.magnitude):
            return EVERYTHING
        return Interval(float(function(a.low - SINGLE * abs(a.low))), float(function(a.high + SINGLE * abs(a.high))))

    return apply


def _absolute(a: Interval) -> Interval:
    return Interval(0.0 if a.low <= 0.0 <= a.high else min(abs(a.low), abs(a.high)), a.magnitude)


RULES: dict[str, Callable[..., Interval]] = {
    "add": lambda a, b: Interval(a.low + b.low, a.high + b.high),
    "subtract": lambda a, b: Interval(a.low - b.high, a.high - b.low),
    "multiply": _multiply,
    "divide": lambda a, b: _multiply(a, _reciprocal(b)),
    "negate": lambda a: Interval(-a.high, -a.low),
    "reciprocal": _reciprocal,
    "power": _power,
    "sqrt": _root,
    "rsqrt": lambda a: _reciprocal(_root(a)) if a.low > 0.0 else Interval(0.0, math.inf),
    "sin": _sine,
    "cos": _cosine,
    "tan": lambda a: Interval(math.tan(a.low), math.tan(a.high)) if a.magnitude < 1.57 else EVERYTHING,
    "asin": lambda a: Interval(-0.5 * math.pi, 0.5 * math.pi),
    "acos": lambda a: Interval(0.0, math.pi),
    "atan": _rising(math.atan),
    "atan2": lambda a, b: Interval(-math.pi, math.pi),
    "remainder": lambda a, b: Interval(min(b.low, 0.0), max(b.high, 0.0)),  # its sign is the divisor's
    "exp": _rising(math.exp),
    "log": _rising(math.log, low=5e-324),
    "abs": _absolute,
    "sign": lambda a: Interval(-1.0, 1.0),
    "tanh": _rising(math.tanh),
    "sinh": _rising(math.sinh),
    "cosh": lambda a: _rising(math.cosh)(_absolute(a)),
    "asinh": _rising(math.asinh),
    "acosh": _rising(math.acosh, low=1.0),
    "atanh": lambda a: _rising(math.atanh)(a) if a.magnitude < 1.0 else EVERYTHING,
    "floor": _rounded(math.floor),
    "ceil": _rounded(math.ceil),
    "minimum": lambda a, b: Interval(min(a.low, b.low), min(a.high, b.high)),
    "maximum": lambda a, b: Interval(max(a.low, b.low), max(a.high, b.high)),
    "select": lambda condition, a, b: Interval(min(a.low, b.low), max(a.high, b.high)),
    "less": lambda a, b: TRUTH,
    "less_equal": lambda a, b: TRUTH,
    "equal": lambda a, b: TRUTH,
    "and": lambda a, b: TRUTH,
    "or": lambda a, b: TRUTH,
    "not": lambda a: TRUTH,
}
