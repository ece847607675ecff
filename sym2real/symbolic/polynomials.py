"""Sines and cosines of a program written out as the sums and products that compute them.

Whole turns leave by ``x - 2π·round(x / 2π)``; adding and subtracting 1.5 · 2^23 rounds a float32 to a whole number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from sym2real.symbolic.program import Instruction, Program
from sym2real.symbolic.sines import TURN, Sine

ROUNDER = 12582912.0
FIRST_PART = float(np.float32(TURN))
REDUCTION = (1.0 / TURN, ROUNDER, FIRST_PART, TURN - FIRST_PART)


def written_out(program: Program, sines: Mapping[int, Sine]) -> Program:
    """The same program with polynomials instead of the calls that are named.

    Args:
        program: what is computed.
        sines: number of a sine or cosine → how it is computed.
    """
    if not sines:
        return program
    return _Writer(program, sines).program()


class _Writer:
    def __init__(self, program: Program, sines: Mapping[int, Sine]) -> None:
        self.old, self.sines = program, sines
        numbers = dict.fromkeys((*program.constants, *REDUCTION, *_coefficients(sines)))
        self.constant = {number: place for place, number in enumerate(numbers, len(program.inputs))}
        self.first = len(program.inputs) + len(numbers)
        self.instructions: dict[Instruction, int] = {}

    def program(self) -> Program:
        number = {value: value for value in range(len(self.old.inputs))}
        number |= {place: self.constant[value] for place, value in enumerate(self.old.constants, len(self.old.inputs))}
        for value, (operation, operands) in zip(self.old.computed, self.old.instructions, strict=True):
            moved = [number[operand] for operand in operands]
            sine = self.sines.get(value)
            number[value] = self._emit(operation, *moved) if sine is None else self._sine(moved[0], sine)
        outputs = tuple(number[output] for output in self.old.outputs)
        return Program(self.old.inputs, tuple(self.constant), tuple(self.instructions), outputs)

    def _emit(self, operation: str, *operands: int) -> int:
        instruction = Instruction(operation, operands)
        return self.instructions.setdefault(instruction, self.first + len(self.instructions))

    def _sine(self, argument: int, sine: Sine) -> int:
        """Horner's rule on what is left of the argument."""
        x, polynomial = self._reduced(argument, sine.reduction), sine.polynomial
        y = x if polynomial.form == "full" else self._emit("multiply", x, x)
        value, *others = (self.constant[number] for number in reversed(polynomial.coefficients))
        for other in others:
            value = self._emit("add", self._emit("multiply", y, value), other)
        return self._emit("multiply", x, value) if polynomial.form == "odd" else value

    def _reduced(self, argument: int, parts: int) -> int:
        """What is left of an argument after whole turns: at most half a turn."""
        if not parts:
            return argument
        inverse, rounder, *turn = (self.constant[number] for number in REDUCTION)
        shifted = self._emit("add", self._emit("multiply", argument, inverse), rounder)
        turns = self._emit("subtract", shifted, rounder)
        for part in turn[:parts]:
            argument = self._emit("subtract", argument, self._emit("multiply", turns, part))
        return argument


def _coefficients(sines: Mapping[int, Sine]) -> Iterator[float]:
    for sine in sines.values():
        yield from sine.polynomial.coefficients
