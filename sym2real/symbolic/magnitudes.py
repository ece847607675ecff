"""Bounds of the absolute value of every value of a program, from bounds of its inputs: |a·b + c| ≤ |a||b| + |c|.

A sine whose argument is proved to be small needs no reduction by whole turns and a shorter polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from sym2real.symbolic.program import Program

# Largest argument in rad → degree, in its square, of the polynomial that then does. A component of a unit vector stands
# in most sines, and its double in many.
SHORT: Mapping[float, int] = {1.05: 3, 2.1: 4}


def _product(a: float, b: float) -> float:
    return 0.0 if 0.0 in (a, b) else a * b  # 0 · ∞ is 0: a bound of numbers that are finite


def _sum(a: float, b: float) -> float:
    return a + b


RULES: dict[str, Callable[..., float]] = {  # nothing is known of other operations
    "add": _sum,
    "subtract": _sum,
    "multiply": _product,
    "negate": lambda a: a,
    "sin": lambda a: min(a, 1.0),
    "cos": lambda a: 1.0,
    "tanh": lambda a: min(a, 1.0),
    "minimum": max,
    "maximum": max,
}


def magnitudes(program: Program, inputs: Mapping[str, float]) -> list[float]:
    """Bound of every value, in the order of their numbers; infinite where nothing is known.

    Args:
        program: what is computed.
        inputs: bounds of its inputs, by name; those that are not given may be anything.
    """
    found = [inputs.get(name, math.inf) for name in program.inputs] + [abs(number) for number in program.constants]
    for operation, operands in program.instructions:
        rule = RULES.get(operation)
        found.append(math.inf if rule is None else rule(*(found[operand] for operand in operands)))
    return found


def short_sines(program: Program, inputs: Mapping[str, float]) -> dict[int, int]:
    """Number of each sine and cosine of a small argument → degree of its polynomial; arguments as of magnitudes."""
    within, found = magnitudes(program, inputs), dict[int, int]()
    for value, (operation, operands) in zip(program.computed, program.instructions, strict=True):
        degrees = [degree for most, degree in SHORT.items() if within[operands[0]] <= most]
        if operation in ("sin", "cos") and degrees:
            found[value] = min(degrees)
    return found
