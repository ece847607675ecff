"""Straight-line program: what the equations compute, in the order in which it can be computed.

Every value has a number: first the inputs, then the constants, then one per instruction. An instruction reads
values with smaller numbers only, so a printer of any language goes through them once from the top. No two
instructions compute the same value.
"""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple


class Instruction(NamedTuple):
    """An operation on values given by their numbers: arithmetic, logic, or one of ``elementary``."""

    operation: str
    operands: tuple[int, ...]


LEAF = Instruction("", ())


@dataclass(frozen=True)
class Program:
    """Instructions in a valid order.

    Args:
        inputs: names of the input values; value ``i`` is ``inputs[i]``.
        constants: value ``len(inputs) + j`` is ``constants[j]``.
        instructions: value ``len(inputs) + len(constants) + k`` is computed by ``instructions[k]``.
        outputs: numbers of the values that are the result, in order.
    """

    inputs: tuple[str, ...]
    constants: tuple[float, ...]
    instructions: tuple[Instruction, ...]
    outputs: tuple[int, ...]

    @cached_property
    def first_instruction(self) -> int:
        """Number of the first computed value."""
        return len(self.inputs) + len(self.constants)

    @cached_property
    def uses(self) -> Counter[int]:
        """How often each value is read, by instructions or as an output."""
        counts = Counter(self.outputs)
        for instruction in self.instructions:
            counts.update(instruction.operands)
        return counts

    @property
    def computed(self) -> range:
        """Numbers of the values that instructions compute."""
        return range(self.first_instruction, self.first_instruction + len(self.instructions))

    def is_constant(self, value: int) -> bool:
        """Whether the value of this number is a constant."""
        return len(self.inputs) <= value < self.first_instruction

    def constant(self, value: int) -> float:
        """The number that a constant value holds."""
        return self.constants[value - len(self.inputs)]

    def instruction(self, value: int) -> Instruction:
        """What computes a value; without a name and operands for inputs and constants."""
        return self.instructions[value - self.first_instruction] if value >= self.first_instruction else LEAF

    def reached_by(self, names: set[str]) -> set[int]:
        """Numbers of all values that depend on any of these inputs."""
        reached = {number for number, name in enumerate(self.inputs) if name in names}
        for number, instruction in enumerate(self.instructions, self.first_instruction):
            if not reached.isdisjoint(instruction.operands):
                reached.add(number)
        return reached
