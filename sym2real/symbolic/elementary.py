"""Functions that equations may use: what each is in SymPy, in Python and in C. A new one is a line here."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import sympy
from sympy import Expr


class Elementary(NamedTuple):
    """A function that a program has an operation for."""

    of: type  # SymPy's class
    evaluate: Callable[..., float]
    c: str  # its name in sym2real/native/functions.h


# By the name of the operation, which is torch's name too.
ELEMENTARY: Mapping[str, Elementary] = {
    "sin": Elementary(sympy.sin, math.sin, "sine"),
    "cos": Elementary(sympy.cos, math.cos, "cosine"),
    "tan": Elementary(sympy.tan, math.tan, "tangent"),
    "asin": Elementary(sympy.asin, math.asin, "arc_sine"),
    "acos": Elementary(sympy.acos, math.acos, "arc_cosine"),
    "atan": Elementary(sympy.atan, math.atan, "arc_tangent"),
    "atan2": Elementary(sympy.atan2, math.atan2, "arc_tangent_2"),
    "remainder": Elementary(sympy.Mod, lambda a, b: a % b, "remainder_of"),
    "exp": Elementary(sympy.exp, math.exp, "exponential"),
    "log": Elementary(sympy.log, math.log, "logarithm"),
    "abs": Elementary(sympy.Abs, abs, "absolute"),
    "sign": Elementary(sympy.sign, lambda value: float((value > 0) - (value < 0)), "sign_of"),
    "tanh": Elementary(sympy.tanh, math.tanh, "hyperbolic_tangent"),
    "sinh": Elementary(sympy.sinh, math.sinh, "hyperbolic_sine"),
    "cosh": Elementary(sympy.cosh, math.cosh, "hyperbolic_cosine"),
    "asinh": Elementary(sympy.asinh, math.asinh, "inverse_hyperbolic_sine"),
    "acosh": Elementary(sympy.acosh, math.acosh, "inverse_hyperbolic_cosine"),
    "atanh": Elementary(sympy.atanh, math.atanh, "inverse_hyperbolic_tangent"),
    "floor": Elementary(sympy.floor, math.floor, "rounded_down"),
    "ceil": Elementary(sympy.ceiling, math.ceil, "rounded_up"),
}
NEAR = 1e-9  # below it a sine is its argument
WRITTEN_OUT: Mapping[type, Callable[..., Expr]] = {  # by the functions above
    sympy.sec: lambda x: 1 / sympy.cos(x),
    sympy.csc: lambda x: 1 / sympy.sin(x),
    sympy.cot: lambda x: 1 / sympy.tan(x),
    sympy.acot: lambda x: sympy.atan(1 / x),
    sympy.sech: lambda x: 1 / sympy.cosh(x),
    sympy.csch: lambda x: 1 / sympy.sinh(x),
    sympy.coth: lambda x: 1 / sympy.tanh(x),
    sympy.frac: lambda x: x - sympy.floor(x),
    # The piece that is not taken must have a derivative too, and 0 / 0 has none.
    sympy.sinc: lambda x: sympy.Piecewise(
        (sympy.sin(sympy.Abs(x)) / sympy.Max(sympy.Abs(x), NEAR), sympy.Abs(x) > NEAR), (1, True)
    ),
    sympy.Heaviside: lambda x, at_0: sympy.Piecewise((0, x < 0), (at_0, sympy.Eq(x, 0)), (1, True)),
}
