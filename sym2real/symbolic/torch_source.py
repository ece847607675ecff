"""Straight-line program → lines of torch code, with torch's fused forms where one operation does the work of two.

``a + c*x`` is ``torch.add(a, x, alpha=c)``, ``a + c*x*y`` is ``torch.addcmul(a, x, y, value=c)``. At 1024 samples
torch's dispatch is what costs, so fewer operations are faster. All other constants are tensors without dimensions:
measured, a Python number as an operand makes an addition 2.5 times as slow.
"""

from collections.abc import Collection, Iterable
from functools import cached_property

from sym2real.symbolic.program import Program

# Torch calls the others as operations are named here.
CALLS = {
    "divide": "div",
    "negate": "neg",
    "power": "pow",
    "select": "where",
    "less": "lt",
    "less_equal": "le",
    "equal": "eq",
    "and": "logical_and",
    "or": "logical_or",
    "not": "logical_not",
}


class TorchLines:
    """Statements that compute a program's values.

    Args:
        program: what to compute.
        variables: a Python name for each input of the program.
        fixed: values that are computed elsewhere, and so never absorbed by an addition.
    """

    def __init__(self, program: Program, variables: Iterable[str], fixed: Collection[int] = ()) -> None:
        self.program, self.fixed = program, frozenset(fixed)
        self.variables = dict(enumerate(variables))

    @cached_property
    def fused(self) -> dict[int, tuple[int, int | None, float]]:
        """Value → (x, y or None, c) for products c·x·y that an addition absorbs."""
        products: dict[int, tuple[int, int | None, float]] = {}
        for instruction in self.program.instructions:
            if instruction.operation in ("add", "subtract"):
                term = instruction.operands[1]
                product = self._single_product(term)
                if product is not None:
                    products[term] = product
        return products

    def _single_product(self, value: int) -> tuple[int, int | None, float] | None:
        if not self._is_private_product(value):
            return None
        left, right = self.program.instruction(value).operands
        if not self.program.is_constant(right):
            return (left, right, 1.0)
        if self._is_private_product(left):
            a, b = self.program.instruction(left).operands
            if not self.program.is_constant(b):
                return (a, b, self.program.constant(right))
        return (left, None, self.program.constant(right))

    def _is_private_product(self, value: int) -> bool:
        product = self.program.instruction(value).operation == "multiply"
        return product and self.program.uses[value] == 1 and value not in self.fixed

    @cached_property
    def absorbed(self) -> set[int]:
        """Values that no line of their own computes."""
        values = set(self.fused)
        for term, (_, second, factor) in self.fused.items():
            if second is not None and factor != 1.0:
                values.add(self.program.instruction(term).operands[0])
        return values

    def name(self, value: int) -> str:
        """The variable that holds a value."""
        return self.variables.get(value, f"v{value}")

    def reads(self, value: int) -> set[int]:
        """Variables and numbers that the line of a value names."""
        operands = self.program.instruction(value).operands
        inner = (self.reads(operand) if operand in self.absorbed else {operand} for operand in operands)
        return set().union(*inner)

    def lines(self, wanted: Collection[int]) -> list[str]:
        """One assignment per value of ``wanted`` that needs one, in order."""
        return [f"v{value} = {self._right_side(value)}" for value in sorted(wanted) if value not in self.absorbed]

    def _right_side(self, value: int) -> str:
        operation, operands = self.program.instruction(value)
        if operation in ("add", "subtract"):
            return self._addition(operation, *operands)
        if operation == "multiply":
            return f"{self.name(operands[0])} * {self.name(operands[1])}"
        return f"torch.{CALLS.get(operation, operation)}({', '.join(map(self.name, operands))})"

    def _addition(self, operation: str, left: int, right: int) -> str:
        sign = 1.0 if operation == "add" else -1.0
        if right not in self.fused:
            return f"{self.name(left)} {'+' if operation == 'add' else '-'} {self.name(right)}"
        first, second, factor = self.fused[right]
        if second is None:
            return f"torch.add({self.name(left)}, {self.name(first)}, alpha={sign * factor!r})"
        value = "" if sign * factor == 1.0 else f", value={sign * factor!r}"
        return f"torch.addcmul({self.name(left)}, {self.name(first)}, {self.name(second)}{value})"
