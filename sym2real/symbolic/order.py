"""The order in which a program's instructions are best written: longest way to a result first.

Compilers keep the order of a long straight text about as it is, and a processor looks some two hundred operations
ahead. Depth first, each waits for the one before; by height, neighbours are independent and run side by side.
Source: T. C. Hu, "Parallel sequencing and assembly line problems", Operations Research 9, 1961.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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


def heights(program: Program, carried: Sequence[int] = ()) -> list[int]:
    """Cycles from the start of each value's instruction to the end of the program.

    Args:
        program: what is ordered.
        carried: inputs, by number, that the first outputs become when the program runs again: the end is then that of
            a second run, so that what the next run waits for comes early.
    """
    height = _heights(program, {})
    return (
        _heights(program, {o: height[i] for o, i in zip(program.outputs, carried, strict=False)}) if carried else height
    )


def _heights(program: Program, after: Mapping[int, int]) -> list[int]:
    height = [after.get(value, 0) for value in range(program.first_instruction + len(program.instructions))]
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


def by_height(program: Program, carried: Sequence[int] = ()) -> Program:
    """The same program, its instructions in falling order of height; arguments as of :func:`heights`."""
    height = heights(program, carried)
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
