"""Beginning of every kernel: precision, vectors, and functions with their polynomials.

Errors, measured over the interval in the kernel's precision: sine and cosine 1.5e-6 (float32) and 1e-14 (float64) up
to 1e5 turns, the exponential function 1e-6 relative (float32; float64 calls the C library). What the C library
computes lane by lane is as exact as that.
"""

from __future__ import annotations

from decimal import Decimal
from functools import lru_cache
from importlib import resources

import numpy as np

from sym2real.symbolic.c_source import literal
from sym2real.symbolic.chebyshev import Polynomial, shortest
from sym2real.symbolic.intervals import Interval
from sym2real.symbolic.sines import HALF_TURN

TURN = Decimal("6.283185307179586476925286766559005768394")
SINE_ERROR = {True: 1e-6, False: 5e-15}
EXPONENTIAL_ERROR = 2e-7
HEADERS = {"cpu": "vectors.h", "gpu": "cuda.h"}


def header(name: str) -> str:
    """Text of one of the fixed C files."""
    return resources.files("sym2real.native").joinpath(name).read_text(encoding="utf-8")


@lru_cache
def preamble(single: bool, machine: str = "cpu") -> str:
    """What every kernel begins with.

    Args:
        single: float32, else float64.
        machine: "cpu" or "gpu".
    """
    return "\n".join(
        [f"#define SINGLE {int(single)}", header(HEADERS[machine]), *_constants(single), header("functions.h")]
    )


def _constants(single: bool) -> list[str]:
    first, second, third = _parts_of_turn(single)
    rounder = 1.5 * 2.0 ** (23 if single else 52)
    numbers = {"TURN_1": first, "TURN_2": second, "TURN_3": third, "ROUNDER": rounder}
    lines = [f"#define {name} {literal(value, single)}" for name, value in numbers.items()]
    for name, function in {"SINE_HALF_TURN": "sin", "COSINE_HALF_TURN": "cos"}.items():
        lines.append(polynomial_macro(name, _known(function, HALF_TURN, SINE_ERROR[single], single), single))
    if single:
        lines.append(
            polynomial_macro("POWER_OF_TWO", _known("exp2", Interval(-0.5, 0.5), EXPONENTIAL_ERROR, True), True)
        )
    return lines


def _known(function: str, interval: Interval, tolerance: float, single: bool) -> Polynomial:
    found = shortest(function, interval, tolerance, single)
    assert found is not None, f"no polynomial for {function}"
    return found


def polynomial_macro(name: str, polynomial: Polynomial, single: bool) -> str:
    """``name(y)`` = p(y) by Horner's rule; of an odd polynomial without its factor x, see :class:`Polynomial`."""
    text, *others = [literal(coefficient, single) for coefficient in reversed(polynomial.coefficients)]
    for other in others:
        text = f"({text} * (y) + {other})"
    return f"#define {name}(y) {text}"


def _parts_of_turn(single: bool) -> tuple[float, float, float]:
    """Three numbers whose sum is 2π; whole multiples of the first two are exact."""
    bits = 10 if single else 28
    first = float(np.ldexp(np.floor(np.ldexp(float(TURN), bits)), -bits))
    rest = TURN - Decimal(first)
    second = float(np.ldexp(np.floor(np.ldexp(float(rest), 2 * bits)), -2 * bits))
    return first, second, float(rest - Decimal(second))
