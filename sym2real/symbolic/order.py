"""The order in which a program's instructions are best written: longest way to a result first.

Compilers keep the order of a long straight text about as it is, and a processor looks some two hundred operations
ahead. Depth first, each waits for the one before; by height, neighbours are independent and run side by side.
Source: T. C. Hu, "Parallel sequencing and assembly line problems", Operations Research 9, 1961.
"""

from __future__ import annotations

from sym2real.symbolic.program import Instruction, Program

# Cycles until a result can be used, roughly, on current processors.
LATENCY = {"sin": 30, "cos": 30, "divide": 15, "reciprocal": 15, "sqrt": 20, "rsqrt": 30}
LATENCY_OF_CALLS = 60  # tan, exp, …
LATENCY_OF_ARITHMETIC = 4
ARITHMETIC = frozenset(
    [
        "add",
        "subtract",
        "multiply",
        "negate",
        "abs",
        "minimum",
        "maximum",
        "select",
        "less",
        "less_equal",
        "equal",
        "and",
        "or",
        "not",
        "sign",
    ]
)


def heights(program: Program) -> list[int]:
    """Cycles from the start of each value's instruction to the end of the program."""
    height = [0] * (program.first_instruction + len(program.instructions))
    for value in reversed(program.computed):
        operation, operands = program.instructions[value - program.first_instruction]
        height[value] += _latency(operation)
        for operand in operands:
            height[operand] = max(height[operand], height[value])
    return height


def _latency(operation: str) -> int:
    if operation in ARITHMETIC:
        return LATENCY_OF_ARITHMETIC
    return LATENCY.get(operation, LATENCY_OF_CALLS)


def by_height(program: Program) -> Program:
    """The same program, its instructions in falling order of height."""
    height = heights(program)
    order = sorted(program.computed, key=lambda value: (-height[value], value))
    number = {value: place for place, value in enumerate(order, program.first_instruction)}

    def moved(value: int) -> int:
        return number.get(value, value)

    instructions = (program.instructions[value - program.first_instruction] for value in order)
    return Program(
        program.inputs,
        program.constants,
        tuple(Instruction(operation, tuple(map(moved, operands))) for operation, operands in instructions),
        tuple(map(moved, program.outputs)),
    )
