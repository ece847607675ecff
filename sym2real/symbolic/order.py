"""The order in which a program's instructions are best written for a compiler that keeps it.

A processor computes some two hundred operations ahead of the one it must finish next, no further. Depth first, each
operation waits for the one before. So the processor is imitated: in each of its cycles the operations begin whose
operands are ready, longest way to a result first; where more values are alive than there are registers, those that
free one go ahead. A product that a sum alone uses is one operation with it.
Source: T. C. Hu, "Parallel sequencing and assembly line problems", Operations Research 9, 1961.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence

from sym2real.symbolic.program import Instruction, Program

# Cycles until a result can be used, roughly, on current processors.
LATENCY = {"sin": 30, "cos": 30, "divide": 18, "reciprocal": 18, "sqrt": 20, "rsqrt": 40}
LATENCY_OF_CALLS = 60  # tan, exp, …
LATENCY_OF_ARITHMETIC = 4
COMPARISONS = ("less", "less_equal", "equal", "and", "or", "not")
SUMS = ("add", "subtract", "multiply", "negate", "abs", "minimum", "maximum", "select", "sign")
ARITHMETIC = frozenset((*SUMS, *COMPARISONS))
A_CYCLE = 2  # operations that begin in one
REGISTERS = 24  # of 32; addresses and what the compiler moves take the others
LOOKED_AT = 4  # ready operations among which one that frees a register is looked for


def absorbed(program: Program) -> dict[int, int]:
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


def heights(program: Program, carried: Sequence[int] = ()) -> list[int]:
    """Cycles from the start of each value's instruction to the end of the program.

    Args:
        program: what is ordered.
        carried: inputs, by number, that the first outputs become when the program runs again: the end is then that of
            a second run, so that what the next run waits for comes early.
    """
    return _heights_over_runs(program, latencies(program, absorbed(program)), carried)


def _heights_over_runs(program: Program, cycles: Sequence[int], carried: Sequence[int]) -> list[int]:
    height = _heights(program, cycles, {})
    if not carried:
        return height
    return _heights(program, cycles, {o: height[i] for o, i in zip(program.outputs, carried, strict=False)})


def _heights(program: Program, latencies: Sequence[int], after: Mapping[int, int]) -> list[int]:
    height = [after.get(value, 0) for value in range(len(latencies))]
    for value in reversed(program.computed):
        reached = height[value] = height[value] + latencies[value]
        for operand in program.instructions[value - program.first_instruction].operands:
            height[operand] = max(height[operand], reached)
    return height


def latencies(program: Program, inside: Mapping[int, int]) -> list[int]:
    """Cycles of each value's instruction; a product inside a sum (of :func:`absorbed`) takes none of its own."""
    found = [0] * program.first_instruction
    for value, (operation, _) in zip(program.computed, program.instructions, strict=True):
        usual = LATENCY_OF_ARITHMETIC if operation in ARITHMETIC else LATENCY.get(operation, LATENCY_OF_CALLS)
        found.append(0 if value in inside else usual)
    return found


def scheduled(program: Program, carried: Sequence[int] = ()) -> Program:
    """The same program in another order; arguments as of :func:`heights`."""
    order = _Schedule(program, carried).order()
    number = {value: place for place, value in enumerate(order, program.first_instruction)}
    moved = [number.get(value, value) for value in range(program.first_instruction + len(order))]
    instructions = (program.instructions[value - program.first_instruction] for value in order)
    return Program(
        program.inputs,
        program.constants,
        tuple(Instruction(operation, tuple(moved[o] for o in operands)) for operation, operands in instructions),
        tuple(moved[output] for output in program.outputs),
    )


class _Schedule:
    """Operations of a program begin, cycle by cycle."""

    def __init__(self, program: Program, carried: Sequence[int]) -> None:
        self.program, self.inside = program, absorbed(program)
        self.latency = latencies(program, self.inside)
        self.height = _heights_over_runs(program, self.latency, carried)
        self.product = {total: product for product, total in self.inside.items()}
        self.reads = {value: self._operands(value) for value in program.computed if value not in self.inside}
        self.readers: dict[int, list[int]] = {}
        for value, operands in self.reads.items():
            for operand in operands:
                self.readers.setdefault(operand, []).append(value)
        self.uses = [len(self.readers.get(value, ())) for value in range(len(self.latency))]
        for output in set(program.outputs):
            self.uses[output] += 1

    def _operands(self, value: int) -> set[int]:
        """What an operation reads, numbers aside; of a product inside it the factors."""
        operands = self.program.instructions[value - self.program.first_instruction].operands
        read = set(operands)
        inner = self.product.get(value)
        if inner is not None:
            read.remove(inner)
            read.update(self.program.instructions[inner - self.program.first_instruction].operands)
        return {operand for operand in read if not self.program.is_constant(operand)}

    def order(self) -> list[int]:
        """Numbers of the instructions; a product that an operation takes in stands before it."""
        first = self.program.first_instruction
        waiting = {value: sum(o >= first for o in operands) for value, operands in self.reads.items()}
        ready = [(-self.height[value], value) for value, count in waiting.items() if not count]
        heapq.heapify(ready)
        begins = dict.fromkeys(waiting, 0)
        later: list[tuple[int, int]] = []
        self.alive = {value for value in range(first) if value in self.readers}
        order, cycle, latency = list[int](), 0, self.latency
        while ready or later:
            while later and later[0][0] <= cycle:
                value = heapq.heappop(later)[1]
                heapq.heappush(ready, (-self.height[value], value))
            for _ in range(min(A_CYCLE, len(ready))):
                value = self._next(ready)
                order += [self.product[value], value] if value in self.product else [value]
                for reader in self.readers.get(value, ()):
                    waiting[reader] -= 1
                    done = cycle + latency[value]
                    begins[reader] = max(begins[reader], done)
                    if not waiting[reader]:
                        heapq.heappush(later, (begins[reader], reader))
            cycle += 1
        return order

    def _next(self, ready: list[tuple[int, int]]) -> int:
        """The operation that begins next; its operands and result are counted."""
        chosen = heapq.heappop(ready)
        if len(self.alive) >= REGISTERS and not self._frees(chosen[1]):
            passed = [chosen]
            while ready and len(passed) < LOOKED_AT:
                passed.append(heapq.heappop(ready))
                if self._frees(passed[-1][1]):
                    chosen = passed[-1]
                    break
            for other in passed:
                if other is not chosen:
                    heapq.heappush(ready, other)
        for operand in self.reads[chosen[1]]:
            self.uses[operand] -= 1
            if not self.uses[operand]:
                self.alive.discard(operand)
        self.alive.add(chosen[1])
        return chosen[1]

    def _frees(self, value: int) -> bool:
        """Whether as many values are alive after an operation as before it, or fewer."""
        return 1 in [self.uses[operand] for operand in self.reads[value]]
