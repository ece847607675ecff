"""Short polynomials for sine, cosine and powers of two on an interval, with the largest error they have there.

Odd in x for the sine, even for the cosine, or neither where the interval lies aside of zero: whichever takes the
fewest operations. A truncated Chebyshev series is within a few percent of the polynomial of least maximal error; the
error is measured on a fine grid, in the precision that will run.
Source: L. N. Trefethen, "Approximation Theory and Approximation Practice", SIAM 2013, ch. 3 and 16.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from sym2real.symbolic.intervals import Interval
from sym2real.trajectory import Array

DEGREE = 25  # of the series that is truncated
FORMS = {"sin": ("odd", "full"), "cos": ("even", "full"), "exp2": ("full",), "log2": ("full",)}
FUNCTIONS = {"sin": np.sin, "cos": np.cos, "exp2": np.exp2, "log2": np.log2}
_NODES = chebyshev.chebpts1(DEGREE + 1)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_NODES, DEGREE))
_TO_POWERS = np.array([np.pad(chebyshev.cheb2poly(row), (0, DEGREE - n)) for n, row in enumerate(np.eye(DEGREE + 1))]).T


@dataclass(frozen=True)
class Polynomial:
    """``x · p(x²)``, ``p(x²)`` or ``p(x)``.

    Args:
        form: "odd", "even" or "full".
        coefficients: of p, constant first.
        error: largest absolute error on the interval, in the precision asked for.
    """

    form: str
    coefficients: tuple[float, ...]
    error: float

    @property
    def operations(self) -> int:
        """Multiplications and fused multiply-adds."""
        return len(self.coefficients) - 1 + {"odd": 2, "even": 1, "full": 0}[self.form]


@lru_cache(maxsize=4096)
def shortest(function: str, interval: Interval, tolerance: float, single: bool) -> Polynomial | None:
    """The polynomial with fewest operations whose error is at most ``tolerance``; None where there is none.

    Args:
        function: a key of :data:`FUNCTIONS`.
        interval: of its argument.
        tolerance: largest absolute error.
        single: evaluated in float32, else in float64.
    """
    forms = FORMS[function][: 2 if interval.high - interval.low < interval.magnitude else 1]  # aside of zero
    found = [_of_form(function, form, interval, tolerance, single) for form in forms]
    return min(filter(None, found), key=lambda one: (one.operations, one.error), default=None)


def _of_form(function: str, form: str, interval: Interval, tolerance: float, single: bool) -> Polynomial | None:
    if form != "full":
        interval = Interval(-interval.magnitude, interval.magnitude)
    series = _series(function, interval)
    if form != "full":
        series[int(form == "even") :: 2] = 0.0  # exactly odd or even
    rest = np.abs(series)[::-1].cumsum()[::-1]
    for size in range(2 if form == "odd" else 1, len(series), 1 if form == "full" else 2):
        if rest[size] <= tolerance:
            found = _polynomial(function, form, series[:size], interval, single)
            if found.error <= tolerance:
                return found
            if rest[size] < 0.01 * tolerance:  # it is rounding that is left
                return None
    return None


@lru_cache(maxsize=4096)
def _interpolated(function: str, interval: Interval) -> tuple[float, ...]:
    middle, half = _middle_and_half(interval)
    return tuple(_TO_SERIES @ FUNCTIONS[function](middle + half * _NODES))


def _series(function: str, interval: Interval) -> Array:
    """Chebyshev coefficients of the function on the interval."""
    return np.array(_interpolated(function, interval))


def _middle_and_half(interval: Interval) -> tuple[float, float]:
    return 0.5 * (interval.low + interval.high), 0.5 * (interval.high - interval.low)


def _polynomial(function: str, form: str, series: Array, interval: Interval, single: bool) -> Polynomial:
    real: type[np.floating] = np.float32 if single else np.float64
    middle, half = _middle_and_half(interval)
    powers = _TO_POWERS[: len(series), : len(series)] @ series / half ** np.arange(len(series)) if half else series[:1]
    if middle and half:
        powers = _shifted(powers, -middle)
    stride, first = {"full": (1, 0), "even": (2, 0), "odd": (2, 1)}[form]
    coefficients = powers[first::stride].astype(real)
    x = np.linspace(interval.low, interval.high, 256).astype(real)
    error = evaluate(form, coefficients, x).astype(np.float64) - FUNCTIONS[function](x.astype(np.float64))
    return Polynomial(form, tuple(float(c) for c in coefficients), float(np.abs(error).max()))


def _shifted(powers: Array, by: float) -> Array:
    """Coefficients of p(x + by)."""
    result = np.zeros(len(powers))
    for coefficient in powers[::-1]:  # Horner's rule on polynomials
        result[1:], result[0] = result[:-1] + by * result[1:], by * result[0]
        result[0] += coefficient
    return result


def evaluate(form: str, coefficients: NDArray[np.floating], x: NDArray[np.floating]) -> NDArray[np.floating]:
    """Value of a polynomial by Horner's rule, in the precision of its arguments."""
    y = x if form == "full" else x * x
    value = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = value * y + coefficient
    return value * x if form == "odd" else value
