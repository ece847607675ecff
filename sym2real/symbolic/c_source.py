"""Straight-line program → lines of C over vectors of samples; the same lines are CUDA C for one sample.

Every value is a constant of its own: the compiler sees plain data flow, orders it for its processor, and fuses
products into sums. ``sym2real/native/*.h`` says what ``v``, ``select`` or ``sine`` are. A user's name never stands
alone in C: columns become ``x_<name>``.
"""

import math
from collections.abc import Collection, Mapping
from functools import lru_cache

import numpy as np

from sym2real.field import is_name
from sym2real.symbolic.elementary import ELEMENTARY
from sym2real.symbolic.program import Program

INFIX = {
    "add": "{} + {}",
    "subtract": "{} - {}",
    "multiply": "{} * {}",
    "divide": "{} / {}",
    "negate": "-{}",
    "less": "{} < {}",
    "less_equal": "{} <= {}",
    "equal": "{} == {}",
    "and": "{} & {}",
    "or": "{} | {}",
    "not": "NOT({})",
}
CALLS = {name: function.c for name, function in ELEMENTARY.items()} | {
    "power": "raised",
    "sqrt": "square_root",
    "rsqrt": "reciprocal_root",
}  # others are called as they are named
CONDITIONS = frozenset(("less", "less_equal", "equal", "and", "or", "not"))


@lru_cache(maxsize=4096)
def literal(value: float, single: bool) -> str:
    """A number in C, of the kernel's precision."""
    if not math.isfinite(value):
        return f"(R({math.copysign(1.0, value)!r}) / R(0.0))" if math.isinf(value) else "(R(0.0) / R(0.0))"
    return f"R({float(np.float32(value)) if single else value!r})"


class CLines:
    """Statements that compute a program's values.

    Args:
        program: what to compute.
        single: float32, else float64.
        names: expressions of values that are computed elsewhere, by number; inputs are ``x_<name>`` else.
    """

    def __init__(self, program: Program, single: bool, names: Mapping[int, str] | None = None) -> None:
        self.program, self.single = program, single
        self.names = {number: f"x_{name}" for number, name in enumerate(program.inputs) if is_name(name)}
        self.names |= dict(names or {})

    def name(self, value: int) -> str:
        """What stands for a value in an infix expression: a number or a variable."""
        known = self.names.get(value)
        if known is not None:
            return known
        return self.number(self.program.constant(value)) if self.program.is_constant(value) else f"v{value}"

    def vector(self, value: int) -> str:
        """What stands for a value where a vector must stand."""
        return f"splat({self.name(value)})" if self.program.is_constant(value) else self.name(value)

    def number(self, value: float) -> str:
        """What stands for a number."""
        return literal(value, self.single)

    def lines(self, wanted: Collection[int]) -> list[str]:
        """One statement per value, in the program's order."""
        return [self._statement(value) for value in self.program.computed if value in wanted]

    def _statement(self, value: int) -> str:
        operation, operands = self.program.instruction(value)
        kind = "mask" if operation in CONDITIONS else "v"
        if operation in INFIX:
            # Two numbers would make no vector, and conditions are no numbers.
            named = [self.vector(operands[0]), *map(self.name, operands[1:])]
            right = INFIX[operation].format(*named)
        else:
            right = f"{CALLS.get(operation, operation)}({', '.join(map(self.vector, operands))})"
        return f"const {kind} v{value} = {right};"
