"""SymPy expressions → graph: every function that equations may use, and a refusal by name for all others."""

import math
from collections.abc import Mapping

import sympy
from sympy import Expr

from sym2real.errors import ModelError, UnknownNameError
from sym2real.symbolic.elementary import ELEMENTARY, WRITTEN_OUT
from sym2real.symbolic.graph import UNIT, Graph, Lowered

OPERATIONS = {function.of: (name, function.evaluate) for name, function in ELEMENTARY.items()}
COMPARE: Mapping[type, tuple[str, bool]] = {  # operation, operands exchanged
    sympy.StrictLessThan: ("less", False),
    sympy.LessThan: ("less_equal", False),
    sympy.StrictGreaterThan: ("less", True),
    sympy.GreaterThan: ("less_equal", True),
    sympy.Equality: ("equal", False),
}


class Lowering:
    """Adds expressions to a graph.

    Args:
        graph: its inputs are the names that expressions may contain.
        definitions: names that stand for expressions over the inputs or each other.
        numbers: inputs that are these numbers.
        values: names that stand for what the graph computes already.

    Raises:
        ModelError: for functions that are not supported, by name.
        UnknownNameError: for symbols that are not inputs.
    """

    def __init__(
        self,
        graph: Graph,
        definitions: Mapping[str, Expr] | None = None,
        numbers: Mapping[str, float] | None = None,
        values: Mapping[str, Lowered] | None = None,
    ) -> None:
        self.graph, self.values = graph, dict(values or {})
        self.definitions, self.numbers = dict(definitions or {}), dict(numbers or {})
        self._lowered: dict[Expr, Lowered] = {}

    def lower(self, expression: Expr) -> Lowered:
        """Add an expression to the graph."""
        lowered = self._lowered.get(expression)
        if lowered is None:
            lowered = self._lowered[expression] = self._lower(expression)
        return lowered

    def _lower(self, expression: Expr) -> Lowered:
        if expression.is_Symbol:
            return self._symbol(expression.name)
        if expression.is_Add:
            return self.graph.sum([self.lower(term) for term in expression.args])
        if expression.is_Mul:
            return self._product(expression)
        if isinstance(expression, sympy.Pow):
            return self._power(expression)
        return self._function(expression) if expression.args else self._constant(expression)

    def _constant(self, expression: Expr) -> Lowered:
        if not (expression.is_Float or (expression.is_finite and expression.is_extended_real)):
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
        if name in self.values:
            return self.values[name]
        if name not in self.graph.inputs:
            raise UnknownNameError("symbol", name, (*self.graph.names, *self.definitions))
        return (1.0, self.graph.inputs[name])

    def _product(self, expression: Expr) -> Lowered:
        above, below = list[Lowered](), list[Lowered]()
        for factor in expression.args:
            if factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                below.append(self.lower(sympy.Pow(factor.base, -factor.exp)))
            else:
                above.append(self.lower(factor))
        quotient = self.graph.product(above)
        return self.graph.divide(quotient, self.graph.product(below)) if below else quotient

    def _power(self, expression: Expr) -> Lowered:
        base, exponent = expression.args
        if exponent.is_number and exponent.is_negative:
            return self.graph.divide((1.0, UNIT), self.lower(sympy.Pow(base, -exponent)))
        if exponent.is_number and float(exponent).is_integer():
            return self.graph.integer_power(self.lower(base), int(exponent))
        if exponent.is_Rational and exponent.q == 2:
            return self.graph.integer_power(self.graph.function("sqrt", math.sqrt, self.lower(base)), int(exponent.p))
        return self.graph.function("power", math.pow, self.lower(base), self.lower(exponent))

    def _function(self, expression: Expr) -> Lowered:
        operation = OPERATIONS.get(type(expression))
        if operation is not None:
            return self.graph.function(*operation, *map(self.lower, expression.args))
        if isinstance(expression, sympy.Min | sympy.Max):
            return self._extremum(expression)
        if isinstance(expression, sympy.Piecewise):
            return self._piecewise(expression)
        written_out = WRITTEN_OUT.get(type(expression))
        if written_out is not None:
            return self.lower(written_out(*expression.args))
        raise ModelError(f"function {type(expression).__name__} is not supported in equations: {expression}")

    def _extremum(self, expression: Expr) -> Lowered:
        name, evaluate = ("minimum", min) if isinstance(expression, sympy.Min) else ("maximum", max)
        arguments = sorted((self.lower(argument) for argument in expression.args), key=lambda pair: pair[1])
        result = arguments[-1]
        for argument in arguments[-2::-1]:  # constants last: one clamp
            result = self.graph.function(name, evaluate, result, argument)
        return result

    def _piecewise(self, expression: Expr) -> Lowered:
        *_, (last, condition) = expression.args
        pieces = expression.args[:-1] if condition == sympy.true else expression.args
        result = self.graph.whole(self.lower(last)) if condition == sympy.true else self.graph.constant(math.nan)
        for value, condition in reversed(pieces):
            result = self.graph.node("select", self.condition(condition), self.graph.whole(self.lower(value)), result)
        return (1.0, result)

    def condition(self, expression: Expr) -> int:
        """Node of a truth value."""
        if isinstance(expression, sympy.Not):
            return self.graph.node("not", self.condition(expression.args[0]))
        if isinstance(expression, sympy.And | sympy.Or):
            name = "and" if isinstance(expression, sympy.And) else "or"
            first, *others = (self.condition(argument) for argument in expression.args)
            for other in others:
                first = self.graph.node(name, first, other)
            return first
        if isinstance(expression, sympy.Unequality):
            return self.graph.node("not", self.condition(sympy.Eq(*expression.args)))
        relation = COMPARE.get(type(expression))
        if relation is not None:
            name, exchanged = relation
            sides = [self.graph.whole(self.lower(side)) for side in expression.args]
            return self.graph.node(name, *(reversed(sides) if exchanged else sides))
        raise ModelError(f"condition {type(expression).__name__} is not supported in equations: {expression}")
