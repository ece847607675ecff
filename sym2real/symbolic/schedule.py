"""Graph of sums and products → straight-line program: equal pairs computed once, depth first."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import combinations
from typing import Any

from sym2real.symbolic.graph import Graph, Term
from sym2real.symbolic.program import Instruction, Program

Operand = int | tuple[str, Any]  # number of an instruction, or a leaf
Pair = tuple[Any, Any]


def make_program(graph: Graph, outputs: Sequence[int]) -> Program:
    """The program that computes these nodes."""
    products, sums = _groups(graph, outputs)
    share_pairs(products, lambda a, b: graph.node("product", (a, b)), lambda number, _: number, _always)
    share_pairs(sums, lambda a, b: graph.node("sum", 0.0, (a, b)), lambda number, _: (number, 1.0), _saves_additions)
    return _Writer(graph, products, sums).program(outputs)


def _operands(graph: Graph, number: int) -> Iterable[int]:
    kind, *content = graph.nodes[number]
    if kind in ("constant", "input"):
        return ()
    if kind == "product":
        return tuple(content[0])
    return tuple(node for node, _ in content[1]) if kind == "sum" else tuple(content)


def _groups(graph: Graph, outputs: Sequence[int]) -> tuple[dict[int, list[int]], dict[int, list[Term]]]:
    products, sums, seen, waiting = dict[int, list[int]](), dict[int, list[Term]](), set[int](), list(outputs)
    while waiting:
        number = waiting.pop()
        if number in seen:
            continue
        seen.add(number)
        kind, *content = graph.nodes[number]
        if kind == "product":
            products[number] = list(content[0])
        elif kind == "sum":
            sums[number] = list(content[1])
        waiting += _operands(graph, number)
    return products, sums


def _always(_: Pair, count: int) -> bool:
    return count >= 2


def _saves_additions(pair: Pair, count: int) -> bool:
    """A shared sum starts with an extra scaling unless a coefficient is 1."""
    return count >= (2 if 1.0 in (pair[0][1], pair[1][1]) else 3)


def share_pairs(
    groups: dict[int, list[Any]],
    make: Callable[[Any, Any], int],
    item: Callable[[int, Any], Any],
    worth: Callable[[Pair, int], bool],
) -> None:
    """Replace, most frequent first, each pair of items that stands in several groups by one new item.

    Args:
        groups: items of each n-ary node, changed in place; groups of the new pairs are added.
        make: number of the node of a pair.
        item: what stands for that node in a group.
        worth: whether a pair in so many groups is worth a value of its own.
    """
    places: dict[Pair, set[int]] = {}
    for group, items in groups.items():
        for pair in _pairs(items):
            places.setdefault(pair, set()).add(group)
    heap = [(-len(place), pair) for pair, place in places.items() if worth(pair, len(place))]
    heapq.heapify(heap)
    while heap:
        count, pair = heapq.heappop(heap)
        found = places[pair]
        if len(found) != -count:
            if worth(pair, len(found)):
                heapq.heappush(heap, (-len(found), pair))
            continue
        number = make(*pair)
        groups.setdefault(number, list(pair))
        for group in sorted(found - {number}):
            for old in _pairs(groups[group]):
                places[old].discard(group)
            items = groups[group]
            items.remove(pair[0])
            items.remove(pair[1])
            items.append(item(number, pair))
            items.sort()
            for new in _pairs(items):
                places.setdefault(new, set()).add(group)
                if worth(new, len(places[new])):
                    heapq.heappush(heap, (-len(places[new]), new))


def _pairs(items: list[Any]) -> set[Pair]:
    return set(combinations(items, 2))


class _Writer:
    """Writes instructions depth first; every node once."""

    def __init__(self, graph: Graph, products: dict[int, list[int]], sums: dict[int, list[Term]]) -> None:
        self.graph, self.products, self.sums = graph, products, sums
        self.uses: Counter[int] = Counter()
        for items in products.values():
            self.uses.update(items)
        for terms in sums.values():
            self.uses.update(node for node, _ in terms)
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
                    self.written[number] = self._product(self.products.get(number, content[0]))
                case "sum":
                    self.written[number] = self._sum(content[0], self.sums.get(number, content[1]))
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
        if coefficient == 1.0:
            return value
        return self._emit("negate", value) if coefficient == -1.0 else self._times(value, coefficient)

    def _times(self, value: Operand, coefficient: float) -> int:
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
        return (rank, node in self.products and self.uses[node] == 1, node)
