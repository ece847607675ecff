"""Straight-line program → lines of C over vectors of samples; the same lines are CUDA C for one sample.

Every value is a constant of its own: the compiler sees plain data flow, keeps the order in which
:mod:`sym2real.symbolic.order` wrote it, and fuses products into sums. ``sym2real/native/*.h`` says what ``v``,
``select`` or ``sine`` are. A user's name never stands alone in C: columns become ``x_<name>``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from sym2real.symbolic.program import Program
from sym2real.symbolic.sines import TURN, Sine

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
CALLS = {
    "power": "raised",
    "sqrt": "square_root",
    "rsqrt": "reciprocal_root",
    "reciprocal": "reciprocal",
    "sin": "sine",
    "cos": "cosine",
    "tan": "tangent",
    "asin": "arc_sine",
    "acos": "arc_cosine",
    "atan": "arc_tangent",
    "atan2": "arc_tangent_2",
    "exp": "exponential",
    "log": "logarithm",
    "abs": "absolute",
    "sign": "sign_of",
    "tanh": "hyperbolic_tangent",
    "minimum": "minimum",
    "maximum": "maximum",
    "select": "select",
}
CONDITIONS = frozenset(("less", "less_equal", "equal", "and", "or", "not"))
ROUNDER = 12582912.0  # 1.5 · 2^23: adding and subtracting it rounds a float32 to a whole number


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
        sines: how sines and cosines are computed; those that are not named are called with any argument.
        names: expressions of values that are computed elsewhere, by number; inputs are ``x_<name>`` else.
        table: collects the numbers of the text, which are then ``k[i]``; written in place without one. A compiler
            makes whole vectors of numbers that it sees, and they crowd the first-level cache.
    """

    def __init__(
        self,
        program: Program,
        single: bool,
        sines: Mapping[int, Sine] | None = None,
        names: Mapping[int, str] | None = None,
        table: list[str] | None = None,
    ) -> None:
        self.program, self.single, self.sines = program, single, sines or {}
        self.names = {number: f"x_{name}" for number, name in enumerate(program.inputs)} | dict(names or {})
        self.table = table
        self._reduced: dict[tuple[int, int], str] = {}

    def name(self, value: int) -> str:
        """What stands for a value in an infix expression: a number or a variable."""
        if value in self.names:
            return self.names[value]
        return self.number(self.program.constant(value)) if self.program.is_constant(value) else f"v{value}"

    def vector(self, value: int) -> str:
        """What stands for a value where a vector must stand."""
        return f"splat({self.name(value)})" if self.program.is_constant(value) else self.name(value)

    def number(self, value: float) -> str:
        written = literal(value, self.single)
        if self.table is None:
            return written
        if written not in self.table:
            self.table.append(written)
        return f"k[{self.table.index(written)}]"

    def lines(self, wanted: Collection[int]) -> list[str]:
        """One statement or more per value, in the program's order."""
        return [line for value in self.program.computed if value in wanted for line in self._statement(value)]

    def _statement(self, value: int) -> list[str]:
        operation, operands = self.program.instructions[value - self.program.first_instruction]
        if value in self.sines:
            return self._sine(value, operands[0], self.sines[value])
        kind = "mask" if operation in CONDITIONS else "v"
        if operation in INFIX:
            # Two numbers would make no vector, and conditions are no numbers.
            named = [self.vector(operands[0]), *map(self.name, operands[1:])]
            right = INFIX[operation].format(*named)
        else:
            right = f"{CALLS[operation]}({', '.join(map(self.vector, operands))})"
        return [f"const {kind} v{value} = {right};"]

    def _sine(self, value: int, argument: int, sine: Sine) -> list[str]:
        x, lines = self.vector(argument), list[str]()
        if sine.reduction:
            key = (argument, sine.reduction)
            if key not in self._reduced:
                self._reduced[key] = f"v{value}_r"
                lines += self._reduction(f"v{value}", x, sine.reduction)
            x = self._reduced[key]
        polynomial, y = sine.polynomial, x
        if polynomial.form != "full":
            y = f"v{value}_s"
            lines.append(f"const v {y} = {x} * {x};")
        right, *others = [self.number(c) for c in reversed(polynomial.coefficients)]
        if not others:
            right = f"splat({right})"
        for coefficient in others:
            right = f"({right} * {y} + {coefficient})"
        lines.append(f"const v v{value} = {f'{x} * {right}' if polynomial.form == 'odd' else right};")
        return lines

    def _reduction(self, name: str, x: str, parts: int) -> list[str]:
        """What is left of an argument after whole turns: at most half a turn."""
        first = float(np.float32(TURN))
        turns = f"({x} * {self.number(1.0 / TURN)} + {self.number(ROUNDER)}) - {self.number(ROUNDER)}"
        left = f"{x} - {name}_k * {self.number(first)}"
        if parts == 2:
            left = f"({left}) - {name}_k * {self.number(TURN - first)}"
        return [f"const v {name}_k = {turns};", f"const v {name}_r = {left};"]
