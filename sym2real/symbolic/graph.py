"""SymPy expressions → one graph of sums and products in which equal parts are one node (hash-consing).

A lowered expression is a pair (number, node): the number factored out of a product goes where it costs least,
usually into the coefficient of a sum. :data:`UNIT` is the node of the number 1, so a constant is (value, UNIT).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import sympy
from sympy import Expr

from sym2real.errors import ModelError, UnknownNameError

UNIT = 0
Lowered = tuple[float, int]
Term = tuple[int, float]  # node, coefficient
LONGEST_CHAIN = 8  # larger integer powers are squared, not chained

UNARY: Mapping[type, tuple[str, Callable[[float], float]]] = {
    sympy.sin: ("sin", math.sin),
    sympy.cos: ("cos", math.cos),
    sympy.tan: ("tan", math.tan),
    sympy.asin: ("asin", math.asin),
    sympy.acos: ("acos", math.acos),
    sympy.atan: ("atan", math.atan),
    sympy.exp: ("exp", math.exp),
    sympy.log: ("log", math.log),
    sympy.Abs: ("abs", abs),
    sympy.sign: ("sign", lambda value: float((value > 0) - (value < 0))),
    sympy.tanh: ("tanh", math.tanh),
}
COMPARE: Mapping[type, tuple[str, bool]] = {  # operation, operands exchanged
    sympy.StrictLessThan: ("less", False),
    sympy.LessThan: ("less_equal", False),
    sympy.StrictGreaterThan: ("less", True),
    sympy.GreaterThan: ("less_equal", True),
    sympy.Equality: ("equal", False),
}


class Graph:
    """Grows by :meth:`lower`; nodes are tuples ``(kind, …)`` found by their number.

    Args:
        names: the inputs that expressions may contain.
        definitions: names that stand for expressions over the inputs or each other.
        fixed: inputs that hardly ever change (parameters); products keep them together.
        numbers: inputs that are these numbers.

    Raises:
        ModelError: for functions that are not supported, by name.
        UnknownNameError: for symbols that are not inputs.
    """

    def __init__(
        self,
        names: Sequence[str],
        definitions: Mapping[str, Expr] | None = None,
        fixed: Collection[str] = (),
        numbers: Mapping[str, float] | None = None,
    ) -> None:
        self.names, self.numbers = tuple(names), dict(numbers or {})
        self.definitions = dict(definitions or {})
        self.nodes: list[tuple[Any, ...]] = []
        self.varying: list[bool] = []
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._lowered: dict[Expr, Lowered] = {}
        self.node("constant", 1.0)
        for name in self.names:
            self._number(("input", name), name not in fixed)

    def _number(self, node: tuple[Any, ...], varies: bool) -> int:
        number = self._numbers.setdefault(node, len(self.nodes))
        if number == len(self.nodes):
            self.nodes.append(node)
            self.varying.append(varies)
        return number

    def node(self, kind: str, *content: Any) -> int:
        """Number of the node, an earlier one where it exists already."""
        if kind == "sum":
            varies = any(self.varying[term] for term, _ in content[1])
        elif kind == "product":
            varies = any(self.varying[factor] for factor in content[0])
        elif kind == "constant":
            varies = False
        else:
            varies = any(self.varying[operand] for operand in content)
        return self._number((kind, *content), varies)

    def constant(self, value: float) -> int:
        return self.node("constant", value)

    def whole(self, lowered: Lowered) -> int:
        """The node that holds number times node."""
        number, node = lowered
        if node == UNIT:
            return self.constant(number)
        return node if number == 1.0 else self.node("sum", 0.0, ((node, number),))

    def lower(self, expression: Expr) -> Lowered:
        """Add an expression to the graph."""
        found = self._lowered.get(expression)
        if found is None:
            found = self._lowered[expression] = self._lower(expression)
        return found

    def _lower(self, expression: Expr) -> Lowered:
        if expression.is_Symbol:
            return self._symbol(expression.name)
        if expression.is_Add:
            return self.sum(self.lower(term) for term in expression.args)
        if expression.is_Mul:
            return self._product(expression)
        if isinstance(expression, sympy.Pow):
            return self._power(expression)
        if expression.is_number and not expression.args:
            return self._constant(expression)
        return self._function(expression)

    def _constant(self, expression: Expr) -> Lowered:
        if not expression.is_extended_real:
            raise ModelError(f"{expression} ({type(expression).__name__}) is not supported in equations")
        try:
            return (float(expression), UNIT)
        except (TypeError, OverflowError) as error:
            raise ModelError(f"{expression} ({type(expression).__name__}) is not supported in equations") from error

    def _symbol(self, name: str) -> Lowered:
        if name in self.definitions:
            expression = self.definitions.pop(name)  # popped, so that a cycle is an unknown name
            lowered = self.lower(expression)
            self.definitions[name] = expression
            return lowered
        if name in self.numbers:
            return (self.numbers[name], UNIT)
        if ("input", name) not in self._numbers:
            raise UnknownNameError("symbol", name, (*self.names, *self.definitions))
        return (1.0, self._numbers["input", name])

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
        fixed = sorted(node for node in flat if not self.varying[node])
        moving = sorted(node for node in flat if self.varying[node])
        if moving and len(fixed) > 1:
            moving, fixed = sorted([*moving, self.node("product", tuple(fixed))]), []
        nodes = sorted(moving + fixed)
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

    def _product(self, expression: Expr) -> Lowered:
        above, below = list[Lowered](), list[Lowered]()
        for factor in expression.args:
            exponent = factor.exp if isinstance(factor, sympy.Pow) else None
            if exponent is not None and exponent.is_number and exponent.is_negative:
                below.append(self.lower(sympy.Pow(factor.base, -exponent)))
            else:
                above.append(self.lower(factor))
        return self.divide(self.product(above), self.product(below))

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

    def _power(self, expression: Expr) -> Lowered:
        base, exponent = expression.args
        if exponent.is_number and exponent.is_negative:
            return self.divide((1.0, UNIT), self.lower(sympy.Pow(base, -exponent)))
        if exponent.is_number and float(exponent).is_integer():
            return self.integer_power(self.lower(base), int(exponent))
        if exponent.is_Rational and exponent.q == 2:
            return self.integer_power(self.function("sqrt", math.sqrt, self.lower(base)), int(exponent.p))
        return self.function("power", math.pow, self.lower(base), self.lower(exponent))

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
                found = ", ".join(repr(number) for number, _ in arguments)
                raise ModelError(f"{name}({found}) has no finite real value") from error
        return (1.0, self.node(name, *(self.whole(argument) for argument in arguments)))

    def _function(self, expression: Expr) -> Lowered:
        for function, (name, evaluate) in UNARY.items():
            if isinstance(expression, function):
                return self.function(name, evaluate, self.lower(expression.args[0]))
        if isinstance(expression, sympy.atan2):
            return self.function("atan2", math.atan2, *(self.lower(argument) for argument in expression.args))
        if isinstance(expression, sympy.Min | sympy.Max):
            return self._extremum(expression)
        if isinstance(expression, sympy.Piecewise):
            return self._piecewise(expression)
        raise ModelError(f"function {type(expression).__name__} is not supported in equations: {expression}")

    def _extremum(self, expression: Expr) -> Lowered:
        name, evaluate = ("minimum", min) if isinstance(expression, sympy.Min) else ("maximum", max)
        arguments = sorted((self.lower(argument) for argument in expression.args), key=lambda pair: pair[1])
        result = arguments[-1]
        for argument in arguments[-2::-1]:  # constants last: one clamp
            result = self.function(name, evaluate, result, argument)
        return result

    def _piecewise(self, expression: Expr) -> Lowered:
        *_, (last, condition) = expression.args
        pieces = expression.args[:-1] if condition == sympy.true else expression.args
        result = self.whole(self.lower(last)) if condition == sympy.true else self.constant(math.nan)
        for value, condition in reversed(pieces):
            result = self.node("select", self.condition(condition), self.whole(self.lower(value)), result)
        return (1.0, result)

    def condition(self, expression: Expr) -> int:
        """Node of a truth value."""
        if isinstance(expression, sympy.Not):
            return self.node("not", self.condition(expression.args[0]))
        if isinstance(expression, sympy.And | sympy.Or):
            name = "and" if isinstance(expression, sympy.And) else "or"
            first, *others = (self.condition(argument) for argument in expression.args)
            for other in others:
                first = self.node(name, first, other)
            return first
        if isinstance(expression, sympy.Unequality):
            return self.node("not", self.condition(sympy.Eq(*expression.args)))
        for relation, (name, exchanged) in COMPARE.items():
            if isinstance(expression, relation):
                sides = [self.whole(self.lower(side)) for side in expression.args]
                return self.node(name, *(reversed(sides) if exchanged else sides))
        raise ModelError(f"condition {type(expression).__name__} is not supported in equations: {expression}")
