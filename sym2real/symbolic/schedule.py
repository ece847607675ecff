"""Graph of sums and products → straight-line program: every node computed once, depth first."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from sym2real.symbolic.graph import Graph, Term, operands_of
from sym2real.symbolic.program import Instruction, Program

Operand = int | tuple[str, Any]  # number of an instruction, or a leaf


def make_program(graph: Graph, outputs: Sequence[int]) -> Program:
    """The program that computes these nodes."""
    return _Writer(graph, outputs).program(outputs)


def _uses(graph: Graph, outputs: Sequence[int]) -> Counter[int]:
    """How often each node that the outputs need is an operand."""
    uses, seen, waiting = Counter[int](), set[int](), list(outputs)
    while waiting:
        number = waiting.pop()
        if number not in seen:
            seen.add(number)
            operands = operands_of(graph.nodes[number])
            uses.update(operands)
            waiting += operands
    return uses


class _Writer:
    """Writes instructions depth first; every node once."""

    def __init__(self, graph: Graph, outputs: Sequence[int]) -> None:
        self.graph, self.uses = graph, _uses(graph, outputs)
        self.instructions: list[tuple[str, tuple[Operand, ...]]] = []
        self.numbers: dict[tuple[str, tuple[Operand, ...]], int] = {}
        self.written: dict[int, Operand] = {}

    def program(self, outputs: Sequence[int]) -> Program:
        """Everything that these nodes of the graph need, in order."""
        results = [self.write(number) for number in outputs]
        constants = dict.fromkeys(
            operand[1]
            for operands in (*(operands for _, operands in self.instructions), results)
            for operand in operands
            if isinstance(operand, tuple) and operand[0] == "constant"
        )
        names = self.graph.names
        leaves = {("input", name): number for number, name in enumerate(names)}
        leaves |= {("constant", value): number for number, value in enumerate(constants, len(names))}

        def final(operand: Operand) -> int:
            return leaves[operand] if isinstance(operand, tuple) else operand + len(leaves)

        instructions = [Instruction(name, tuple(map(final, operands))) for name, operands in self.instructions]
        return Program(names, tuple(constants), tuple(instructions), tuple(map(final, results)))

    def write(self, number: int) -> Operand:
        """The place of a node's value, computed once."""
        if number not in self.written:
            kind, *content = self.graph.nodes[number]
            match kind:
                case "constant" | "input":
                    self.written[number] = (kind, content[0])
                case "product":
                    self.written[number] = self._product(content[0])
                case "sum":
                    self.written[number] = self._sum(*content)
                case "square":
                    self.written[number] = self._emit("multiply", *[self.write(content[0])] * 2)
                case _:
                    self.written[number] = self._emit(kind, *map(self.write, content))
        return self.written[number]

    def _emit(self, operation: str, *operands: Operand) -> int:
        key = (operation, operands)
        if key not in self.numbers:
            self.numbers[key] = len(self.instructions)
            self.instructions.append(key)
        return self.numbers[key]

    def _product(self, factors: Sequence[int]) -> Operand:
        result, *others = map(self.write, factors)
        for factor in others:
            result = self._emit("multiply", result, factor)
        return result

    def _scaled(self, node: int, coefficient: float) -> Operand:
        value = self.write(node)
        if abs(coefficient) == 1.0:
            return value if coefficient > 0.0 else self._emit("negate", value)
        return self._emit("multiply", value, ("constant", coefficient))

    def _sum(self, offset: float, terms: Sequence[Term]) -> Operand:
        first = min(terms, key=self._unfit_to_lead)
        if first[1] != 1.0 and offset != 0.0:  # number + c*x is one operation in torch and in C
            result: Operand = ("constant", offset)
            offset, others = 0.0, list(terms)
        else:
            result = self._scaled(*first)
            others = [term for term in terms if term is not first]
        for node, coefficient in others:
            if coefficient == -1.0:
                result = self._emit("subtract", result, self.write(node))
            else:
                result = self._emit("add", result, self._scaled(node, coefficient))
        return self._emit("add", result, ("constant", offset)) if offset != 0.0 else result

    def _unfit_to_lead(self, term: Term) -> tuple[int, bool, int]:
        """Terms without coefficient lead; products used once are better added (a fused multiply-add)."""
        node, coefficient = term
        rank = 0 if coefficient == 1.0 else 1 if coefficient != -1.0 else 2
        return (rank, self.graph.nodes[node][0] == "product" and self.uses[node] == 1, node)
