"""How much an error of one value can change the results of a program: reverse accumulation over intervals.

An error δ of value i changes result j by at most |∂j/∂i| δ. Bounds of the derivatives are multiplied and added
backwards through the program; the largest over the results is the influence. A sine inside ``0.0006*sin(…)`` may then
be a thousand times as coarse as one that is a velocity.
Source: A. Griewank, A. Walther, "Evaluating Derivatives", SIAM 2008, section 15.2 (reverse mode, error estimates).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from sym2real.symbolic.intervals import Interval
from sym2real.symbolic.program import Program


def influences(program: Program, within: Sequence[Interval], outputs: Sequence[int]) -> list[float]:
    """Bound of the change of any result per error, for every value; infinite where nothing is known.

    Args:
        program: what is computed.
        within: bounds of its values, from :func:`sym2real.symbolic.intervals.bounds`.
        outputs: values that count as results.
    """
    largest = [0.0] * (program.first_instruction + len(program.instructions))
    for output in outputs:
        for value, change in _changes(program, within, output).items():
            largest[value] = max(largest[value], change)
    return largest


def _changes(program: Program, within: Sequence[Interval], output: int) -> dict[int, float]:
    changes = {output: 1.0}
    for value in range(output, program.first_instruction - 1, -1):
        instruction = program.instruction(value)
        if value not in changes or instruction is None:
            continue
        given = [within[operand] for operand in instruction.operands]
        slopes = _slopes(instruction.operation, given, within[value])
        for operand, slope in zip(instruction.operands, slopes, strict=True):
            step = 0.0 if 0.0 in (slope, changes[value]) else slope * changes[value]
            changes[operand] = changes.get(operand, 0.0) + step
    return changes


def _slopes(operation: str, given: Sequence[Interval], result: Interval) -> tuple[float, ...]:
    rule = RULES.get(operation)
    return (math.inf,) * len(given) if rule is None else rule(*given, result)


def _over(above: float, below: Interval) -> float:
    """Bound of above / |below|."""
    least = 0.0 if below.low <= 0.0 <= below.high else min(abs(below.low), abs(below.high))
    return math.inf if least == 0.0 else above / least


def _sine_slope(a: Interval, result: Interval) -> tuple[float]:
    # |cos| is sqrt(1 - sin²): small near the crest, where the result is proved to stay near ±1.
    least = 0.0 if result.low <= 0.0 <= result.high else min(abs(result.low), abs(result.high))
    return (math.sqrt(max(0.0, 1.0 - least**2)),)


def _quotient(a: Interval, b: Interval, result: Interval) -> tuple[float, float]:
    return (_over(1.0, b), _over(result.magnitude, b))


RULES: dict[str, Callable[..., tuple[float, ...]]] = {
    "add": lambda *_: (1.0, 1.0),
    "subtract": lambda *_: (1.0, 1.0),
    "multiply": lambda a, b, _: (b.magnitude, a.magnitude),
    "divide": _quotient,
    "negate": lambda *_: (1.0,),
    "reciprocal": lambda a, r: (_over(r.magnitude, a),),
    "sqrt": lambda a, r: (_over(0.5, r),),
    "rsqrt": lambda a, r: (0.5 * r.magnitude**3,),  # d/da of a^(-1/2)
    "sin": _sine_slope,
    "cos": _sine_slope,
    "exp": lambda a, r: (r.magnitude,),
    "tanh": lambda *_: (1.0,),
    "sinh": lambda a, r: (math.hypot(1.0, r.magnitude),),  # cosh² is 1 + sinh²
    "cosh": lambda a, r: (r.magnitude,),
    "asinh": lambda *_: (1.0,),
    "atan": lambda *_: (1.0,),
    "abs": lambda *_: (1.0,),
    "minimum": lambda *_: (1.0, 1.0),
    "maximum": lambda *_: (1.0, 1.0),
    "select": lambda *_: (math.inf, 1.0, 1.0),
}
