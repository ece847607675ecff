"""One graph of sums and products in which equal parts are one node (hash-consing).

A value is a pair (number, node): the number factored out of a product goes where it costs least, usually into the
coefficient of a sum. :data:`UNIT` is the node of the number 1, so a constant is (value, UNIT).
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

from sym2real.errors import ModelError

UNIT = 0
Lowered = tuple[float, int]
Term = tuple[int, float]  # node, coefficient
LONGEST_CHAIN = 3  # larger integer powers are squares of their half


def operands_of(node: tuple[Any, ...]) -> Sequence[int]:
    """The nodes that a node is made of."""
    kind, *content = node
    if kind in ("constant", "input"):
        return ()
    if kind == "product":
        return tuple(content[0])
    return tuple(term for term, _ in content[1]) if kind == "sum" else tuple(content)


class Graph:
    """Nodes are tuples ``(kind, …)`` found by their number.

    Args:
        names: the inputs.
        fixed: inputs that hardly ever change (parameters); products keep them together.
    """

    def __init__(self, names: Sequence[str], fixed: Collection[str] = ()) -> None:
        self.names = tuple(names)
        self.nodes: list[tuple[Any, ...]] = []
        self.varying: list[bool] = []
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._any_fixed = len(fixed) > 0
        self.node("constant", 1.0)
        self.inputs = {name: self._number(("input", name), name not in fixed) for name in self.names}

    def _number(self, node: tuple[Any, ...], varies: bool) -> int:
        number = self._numbers.setdefault(node, len(self.nodes))
        if number == len(self.nodes):
            self.nodes.append(node)
            self.varying.append(varies)
        return number

    def node(self, kind: str, *content: Any) -> int:
        """Number of the node, an earlier one where it exists already."""
        node = (kind, *content)
        return self._number(node, any(self.varying[operand] for operand in operands_of(node)))

    def constant(self, value: float) -> int:
        """The node of a number."""
        return self.node("constant", value)

    def whole(self, lowered: Lowered) -> int:
        """The node that holds number times node."""
        number, node = lowered
        if node == UNIT:
            return self.constant(number)
        return node if number == 1.0 else self.node("sum", 0.0, ((node, number),))

    def sum(self, terms: Iterable[Lowered]) -> Lowered:
        """Sum of lowered terms, equal nodes merged."""
        offset, coefficients = 0.0, dict[int, float]()
        for number, node in terms:
            if node == UNIT:
                offset += number
            else:
                coefficients[node] = coefficients.get(node, 0.0) + number
        merged = [(node, number) for node, number in coefficients.items() if number != 0.0]
        if not merged:
            return (offset, UNIT)
        if len(merged) == 1 and offset == 0.0:
            return (merged[0][1], merged[0][0])
        return (1.0, self.node("sum", offset, tuple(sorted(merged))))

    def product(self, factors: Iterable[Lowered]) -> Lowered:
        """Product of lowered factors; fixed factors are kept together."""
        number, flat = 1.0, list[int]()
        for coefficient, node in factors:
            number *= coefficient
            flat += self._factors(node)
        nodes = sorted(flat)
        if self._any_fixed:
            fixed = [node for node in nodes if not self.varying[node]]
            if 1 < len(fixed) < len(nodes):
                moving = [node for node in nodes if self.varying[node]]
                nodes = sorted([*moving, self.node("product", tuple(fixed))])
        if number == 0.0 or not nodes:
            return (number, UNIT)
        return (number, nodes[0] if len(nodes) == 1 else self.node("product", tuple(nodes)))

    def _factors(self, node: int) -> list[int]:
        if node == UNIT:
            return []
        kind, *content = self.nodes[node]
        if kind != "product":
            return [node]
        return [inner for factor in content[0] for inner in self._factors(factor)]

    def divide(self, above: Lowered, below: Lowered) -> Lowered:
        """Quotient of lowered values.

        Raises:
            ModelError: for a division by the constant zero.
        """
        if below[1] == UNIT and below[0] == 0.0:
            raise ModelError("an equation divides by zero")
        number = above[0] / below[0]
        if below[1] == UNIT:
            return (number, above[1])
        if self.nodes[below[1]][0] == "sqrt":
            return self.product([(number, UNIT), (1.0, above[1]), (1.0, self.node("rsqrt", self.nodes[below[1]][1]))])
        if above[1] == UNIT or not self.varying[below[1]]:
            return self.product([(number, above[1]), (1.0, self.node("reciprocal", below[1]))])
        return (number, self.node("divide", above[1], below[1]))

    def integer_power(self, base: Lowered, exponent: int) -> Lowered:
        """``base**exponent`` by multiplications."""
        if exponent <= LONGEST_CHAIN:
            return self.product([base] * exponent)
        number, half = self.integer_power(base, exponent // 2)
        square = self.node("square", half)
        return self.product([(number * number, square), *([base] if exponent % 2 else [])])

    def function(self, name: str, evaluate: Callable[..., float], *arguments: Lowered) -> Lowered:
        """A function node, or its value where all arguments are numbers."""
        if all(node == UNIT for _, node in arguments):
            try:
                return (float(evaluate(*(number for number, _ in arguments))), UNIT)
            except (ValueError, OverflowError, ZeroDivisionError) as error:
                numbers = ", ".join(repr(number) for number, _ in arguments)
                raise ModelError(f"{name}({numbers}) has no finite real value") from error
        return (1.0, self.node(name, *(self.whole(argument) for argument in arguments)))
