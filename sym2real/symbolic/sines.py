"""How each sine and cosine of a program is computed: which polynomial, after which reduction of its argument.

The error that a call may have is a budget over its influence on the results: what changes a state by a thousandth of
it may be a thousand times as coarse. Arguments that provably stay near zero go straight into a polynomial; others
are first brought to half a turn around zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from sym2real.symbolic.chebyshev import Polynomial, shortest
from sym2real.symbolic.influence import influences
from sym2real.symbolic.intervals import Interval, bounds
from sym2real.symbolic.program import Program

# What one call may change in any result: as much as rounding of a number near four does in single precision. No call is
# held to less than the finest error.
BUDGET = 2.5e-7
COARSEST, FINEST = 0.1, 1e-6
GRID = 8  # intervals are widened to eighths, so that many calls share a polynomial
WIDEST = 8.0  # rad: beyond, a polynomial takes more operations than reduction and a short one
# Relative errors of 2π as one float32, and as a sum of two.
ONE_PART, REDUCTION, SECOND_PART = 3e-8, 3, 1
TURN = 2.0 * math.pi
HALF_TURN = Interval(-math.pi, math.pi)
CALLS = frozenset(("sin", "cos"))


@dataclass(frozen=True)
class Sine:
    """How one call is computed.

    Args:
        reduction: parts of 2π that are subtracted in multiples first: 0, 1 or 2.
        polynomial: of what is left.
    """

    reduction: int
    polynomial: Polynomial


@dataclass(frozen=True)
class Assumed:
    """What is taken for granted of a program's values, and checked while it runs.

    Args:
        inputs: intervals of its inputs, by name.
        longest_reciprocal: of every reciprocal square root.
    """

    inputs: Mapping[str, Interval]
    longest_reciprocal: float = 2.0


def plan_sines(program: Program, assumed: Assumed, outputs: tuple[int, ...]) -> dict[int, Sine]:
    """Number of each sine and cosine → how it is computed in single precision under these assumptions.

    Args:
        program: what is computed.
        assumed: of its inputs.
        outputs: the results whose errors are bounded.
    """
    calls = [value for value in program.computed if program.instructions[value - program.first_instruction][0] in CALLS]
    if not calls:
        return {}
    within = bounds(program, assumed.inputs, assumed.longest_reciprocal)
    influence = influences(program, within, outputs)
    return {value: _chosen(program, value, within, influence[value]) for value in calls}


def _chosen(program: Program, value: int, within: list[Interval], influence: float) -> Sine:
    operation, (argument,) = program.instructions[value - program.first_instruction]
    allowed = BUDGET / influence if influence > 0.0 else COARSEST
    tolerance = 2.0 ** math.floor(math.log2(min(max(allowed, FINEST), COARSEST)))  # powers of two: shared polynomials
    interval = within[argument]
    parts = 1 if ONE_PART * interval.magnitude <= 0.5 * tolerance else 2
    reduced = shortest(operation, HALF_TURN, max(0.5 * tolerance, FINEST), single=True)
    assert reduced is not None  # a series of degree 25 is exact there
    longest = reduced.operations + REDUCTION + (parts - 1) * SECOND_PART
    if interval.magnitude <= WIDEST:
        wider = Interval(math.floor(interval.low * GRID) / GRID, math.ceil(interval.high * GRID) / GRID)
        direct = shortest(operation, wider, max(tolerance, FINEST), single=True)
        if direct is not None and direct.operations <= longest:
            return Sine(0, direct)
    return Sine(parts, reduced)
