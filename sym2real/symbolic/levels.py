"""A program cut into levels: operations that can be computed at once, few kinds of them a level.

Every value is a row; results of one kind and level stand in neighbouring rows. Sums and products are all ``a + b·c``.
An operation that nothing waits for goes with a later one of its kind, so that there are fewer batches.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sym2real.errors import ModelError
from sym2real.symbolic.elementary import ELEMENTARY
from sym2real.symbolic.program import Program

FUSED = "addcmul"  # a + b·c
KINDS = (FUSED, "divide", "power", "sqrt", "rsqrt", "reciprocal", "minimum", "maximum", *ELEMENTARY)
Operand = int | float  # number of a value, or a constant
Operation = tuple[str, tuple[Operand, ...]]


@dataclass(frozen=True)
class Batch:
    """Operations of one kind.

    Args:
        kind: of :data:`KINDS`.
        operands: rows to read, for each operand one per operation.
        first: row of the first result.
    """

    kind: str
    operands: tuple[tuple[int, ...], ...]
    first: int

    @property
    def size(self) -> int:
        """Number of operations."""
        return len(self.operands[0])


@dataclass(frozen=True)
class Levels:
    """A program as batches over rows: inputs, then numbers, then results.

    Args:
        numbers: constants.
        batches: level after level, what may be computed at once.
        outputs: rows of the results.
        rows: how many there are.
    """

    numbers: tuple[float, ...]
    batches: tuple[tuple[Batch, ...], ...]
    outputs: tuple[int, ...]
    rows: int


def cut(program: Program) -> Levels:
    """The program in as many levels as its longest chain has operations.

    Raises:
        ModelError: for an operation that is none of :data:`KINDS` (conditions).
    """
    waiting = _operations(program)
    height, inputs = _heights(waiting), len(program.inputs)
    constants = [operand for _, operands in waiting.values() for operand in operands if isinstance(operand, float)]
    constants += [program.constant(output) for output in program.outputs if program.is_constant(output)]
    numbers = tuple(dict.fromkeys(constants))
    rows: dict[Operand, int] = {number: row for row, number in enumerate(numbers, inputs)}  # floats
    values: dict[int, int] = {value: value for value in range(inputs)}
    levels, row = list[tuple[Batch, ...]](), inputs + len(numbers)
    for left in range(max(height.values(), default=0), 0, -1):
        ready = [
            v for v, (_, operands) in waiting.items() if all(isinstance(o, float) or o in values for o in operands)
        ]
        urgent = {waiting[value][0] for value in ready if height[value] == left}
        level, made = list[Batch](), dict[int, int]()
        for kind in urgent:
            chosen = {value: waiting.pop(value)[1] for value in ready if waiting[value][0] == kind}
            read = [[rows[o] if isinstance(o, float) else values[o] for o in operands] for operands in chosen.values()]
            level.append(Batch(kind, tuple(zip(*read, strict=True)), row))
            made |= dict(zip(chosen, range(row, row + len(chosen)), strict=True))
            row += len(chosen)
            ready = [value for value in ready if value not in chosen]
        values |= made
        levels.append(tuple(level))
    outputs = (rows[program.constant(o)] if program.is_constant(o) else values[o] for o in program.outputs)
    return Levels(numbers, tuple(levels), tuple(outputs), row)


def _operations(program: Program) -> dict[int, Operation]:
    """What computes each value; products that a sum takes in have no row of their own."""
    inside = {product: total for product, total in _absorbed(program).items() if _fits(program, product, total)}
    taken = {total: product for product, total in inside.items()}

    def operand(value: int) -> Operand:
        return program.constant(value) if program.is_constant(value) else value

    found: dict[int, Operation] = {}
    for value, (operation, operands) in zip(program.computed, program.instructions, strict=True):
        if value in inside:
            continue
        given = tuple(map(operand, operands))
        if value in taken:
            (other,) = (operand(source) for source in operands if source != taken[value])
            a, b = map(operand, program.instructions[taken[value] - program.first_instruction].operands)
            found[value] = (FUSED, (other, a, b) if operation == "add" else (other, *_negated(a, b)))
        elif operation in ("add", "subtract"):
            found[value] = (FUSED, (*given, 1.0 if operation == "add" else -1.0))
        elif operation in ("multiply", "negate"):
            found[value] = (FUSED, (0.0, *given, *((-1.0,) if operation == "negate" else ())))
        elif operation in KINDS:
            found[value] = (operation, given)
        else:
            raise ModelError(f"{operation} cannot be computed level by level")
    return found


def _absorbed(program: Program) -> dict[int, int]:
    """Product → the sum or difference that it is one operation with (a fused multiply-add)."""
    found: dict[int, int] = {}
    for value in program.computed:
        operation, operands = program.instructions[value - program.first_instruction]
        if operation not in ("add", "subtract"):
            continue
        for operand in reversed(operands):
            instruction = program.instruction(operand)
            if instruction is not None and instruction.operation == "multiply" and program.uses[operand] == 1:
                found[operand] = value
                break
    return found


def _fits(program: Program, product: int, total: int) -> bool:
    """Whether a sum can take in a product; a difference only one that it subtracts and that has a number in it."""
    operation, (left, right) = program.instructions[total - program.first_instruction]
    if operation == "add":
        return left != right
    factors = program.instructions[product - program.first_instruction].operands
    return product == right != left and any(map(program.is_constant, factors))


def _negated(a: Operand, b: Operand) -> tuple[Operand, Operand]:
    return (-a, b) if isinstance(a, float) else (a, -b)


def _heights(operations: Mapping[int, Operation]) -> dict[int, int]:
    """Operations from each value to the end of the longest chain that it begins."""
    height = dict.fromkeys(operations, 1)
    for value in reversed(list(operations)):
        for operand in operations[value][1]:
            if isinstance(operand, int) and operand in height:
                height[operand] = max(height[operand], height[value] + 1)
    return height
