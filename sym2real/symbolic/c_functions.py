"""Beginning of every kernel: precision, vectors, and functions with their polynomials.

Largest errors, each beside the rounding of the argument: sine and cosine 2e-6 (float32) and 1e-14 (float64), the
exponential function 1e-6 relative (float32; float64 calls the C library). What the C library computes lane by lane is
as exact as that. The polynomials interpolate in Chebyshev points, within a few percent of the least maximal error.
Source: L. N. Trefethen, "Approximation Theory and Approximation Practice", SIAM 2013, ch. 2 and 16.
"""

from collections.abc import Callable
from functools import lru_cache
from importlib import resources

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from sym2real.symbolic.c_source import literal
from sym2real.trajectory import Array

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
        [f"#define SINGLE {int(single)}", header(HEADERS[machine]), *_polynomials(single), header("functions.h")]
    )


def _polynomials(single: bool) -> list[str]:
    """Sine over its argument, and cosine, as functions of the argument's square: in turns up to a half."""
    degree, turn = 5 if single else 10, 2.0 * np.pi
    macros = [
        polynomial("SINE", lambda s: np.sin(turn * np.sqrt(s)) / np.sqrt(s), degree, (0.0, 0.25), single),
        polynomial("COSINE", lambda s: np.cos(turn * np.sqrt(s)), degree, (0.0, 0.25), single),
    ]
    if single:
        macros += [
            polynomial("POWER_OF_TWO", np.exp2, 5, (-0.5, 0.5), single),
            polynomial("LOGARITHM", np.log2, 5, (1.0, 2.0), single),
        ]
    return macros


def polynomial(
    name: str, function: Callable[[Array], Array], degree: int, interval: tuple[float, float], single: bool
) -> str:
    """A macro ``name(y)`` that is close to a function on an interval, by Horner's rule."""
    powers = Chebyshev.interpolate(function, degree, interval).convert(kind=Polynomial).coef.tolist()
    text, *others = [literal(coefficient, single) for coefficient in powers[::-1]]
    for other in others:
        text = f"({text} * (y) + {other})"
    return f"#define {name}(y) {text}"
