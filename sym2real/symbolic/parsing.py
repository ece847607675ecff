"""Text → SymPy expression, by Python's syntax tree alone: nothing in the text is ever evaluated.

Grammar: numbers, names, ``+ - * / **``, the functions of :data:`FUNCTIONS`, ``pi`` and ``E``, comparisons,
``&``/``|``/``~`` (or ``and``/``or``/``not``) and ``Piecewise((value, condition), …, (value, True))``.
"""

import ast
import math
from collections.abc import Callable, Collection

import sympy
from sympy import Expr

from sym2real.errors import ModelError, UnknownNameError
from sym2real.symbolic.expressions import CONSTANTS, FUNCTIONS, applied, product, symbol

LONGEST_TEXT = 200_000
LARGEST_NUMBER_BITS = 1100  # as large as a float gets; a tower of powers would never end

ARITY = {"atan2": (2, 2), "Mod": (2, 2), "Heaviside": (1, 2), "Min": (1, math.inf), "Max": (1, math.inf)}
COMPARISONS: dict[type[ast.cmpop], Callable[[Expr, Expr], Expr]] = {
    ast.Lt: sympy.Lt,
    ast.LtE: sympy.Le,
    ast.Gt: sympy.Gt,
    ast.GtE: sympy.Ge,
    ast.Eq: sympy.Eq,
    ast.NotEq: sympy.Ne,
}
NAMED_COMPARISONS = {"Eq": sympy.Eq, "Ne": sympy.Ne, "Lt": sympy.Lt, "Le": sympy.Le, "Gt": sympy.Gt, "Ge": sympy.Ge}


def parse_expression(text: str, names: Collection[str] | None = None) -> Expr:
    """The expression that ``text`` writes; every name becomes ``symbol(name)``.

    Args:
        text: Python syntax; floats are kept exactly, ratios of integers stay rational.
        names: the names that may stand in it; None allows any.

    Raises:
        ModelError: when the text is not such an expression; names the part that is not.
        UnknownNameError: for a name or function that does not exist, with the nearest ones that do.
    """
    if len(text) > LONGEST_TEXT:
        raise ModelError(f"expected an expression of at most {LONGEST_TEXT} characters, found {len(text)}")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        expression = _Reader(names).visit(tree.body)
    except (SyntaxError, ValueError, TypeError, ArithmeticError) as error:  # SymPy's of what is not real or finite
        raise ModelError(f"expected an expression, found {_short(text)}: {error}") from error
    except (RecursionError, MemoryError) as error:
        raise ModelError(f"expected an expression, found one that is nested too deeply: {_short(text)}") from error
    if not isinstance(expression, Expr):
        raise ModelError(f"expected a number, found a condition: {_short(text)}")
    if not all(math.isfinite(float(number)) for number in expression.atoms(sympy.Float)):
        raise ModelError(f"expected numbers that a float holds, found {_short(text)}")
    if expression.has(sympy.nan, sympy.zoo, sympy.oo, -sympy.oo, sympy.I):
        raise ModelError(f"expected a finite real expression, found {_short(text)} = {expression}")
    return expression


def _short(text: str) -> str:
    return repr(text if len(text) <= 80 else text[:77] + "…")


class _Reader(ast.NodeVisitor):
    """Syntax trees to SymPy; a :class:`ModelError` names the part that is not in the grammar.

    Args:
        names: the names that may stand in it; None allows any.
    """

    def __init__(self, names: Collection[str] | None) -> None:
        self.names = names

    def generic_visit(self, node: ast.AST) -> Expr:
        """What has no method of its own is in no expression."""
        raise ModelError(f"{type(node).__name__} is not allowed in an expression: {_short(_source(node))}")

    def number(self, node: ast.AST) -> Expr:
        """An operand of arithmetic."""
        value = self.visit(node)
        if not isinstance(value, Expr):
            raise ModelError(f"expected a number, found a condition: {_short(_source(node))}")
        return value

    def condition(self, node: ast.AST) -> Expr:
        """An operand of logic, which SymPy keeps apart from numbers."""
        value = self.visit(node)
        if isinstance(value, Expr):
            raise ModelError(f"expected a condition, found a number: {_short(_source(node))}")
        return value

    def visit_Constant(self, node: ast.Constant) -> Expr:
        """Integers stay exact, so that ratios of them do."""
        value = node.value
        if isinstance(value, bool):
            return sympy.true if value else sympy.false
        if isinstance(value, int) and value.bit_length() <= LARGEST_NUMBER_BITS:
            return sympy.Integer(value)
        if isinstance(value, float) and math.isfinite(value):
            return sympy.Float(value)
        raise ModelError(f"expected a finite real number, found {_short(repr(value))}")

    def visit_Name(self, node: ast.Name) -> Expr:
        """A column or parameter; it goes before a constant of the same name."""
        if self.names is not None and node.id in self.names:
            return symbol(node.id)
        if node.id in CONSTANTS:
            return CONSTANTS[node.id]
        if self.names is not None:
            raise UnknownNameError("symbol", node.id, self.names)
        return symbol(node.id)

    def visit_BinOp(self, node: ast.BinOp) -> Expr:
        """``+ - * / **`` of numbers, ``& |`` of conditions."""
        operation = OPERATORS.get(type(node.op))
        if operation is None:
            hint = "; a power is written **" if isinstance(node.op, ast.BitXor) else ""
            raise ModelError(f"operator {type(node.op).__name__} is not allowed: {_short(_source(node))}{hint}")
        read = self.condition if isinstance(node.op, ast.BitAnd | ast.BitOr) else self.number
        return operation(read(node.left), read(node.right))

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Expr:
        """``- +`` of a number, ``~`` or ``not`` of a condition."""
        match node.op:
            case ast.USub():
                return product([sympy.S.NegativeOne, self.number(node.operand)])
            case ast.UAdd():
                return self.number(node.operand)
            case _:
                return sympy.Not(self.condition(node.operand))

    def visit_Compare(self, node: ast.Compare) -> Expr:
        """A chain, as ``0 < x <= 1``, is the conjunction of its links."""
        sides = [self.number(side) for side in (node.left, *node.comparators)]
        relations = []
        for operator, left, right in zip(node.ops, sides, sides[1:], strict=False):
            if type(operator) not in COMPARISONS:
                raise ModelError(f"comparison {type(operator).__name__} is not allowed: {_short(_source(node))}")
            relations.append(COMPARISONS[type(operator)](left, right))
        return sympy.And(*relations)

    def visit_BoolOp(self, node: ast.BoolOp) -> Expr:
        """``and`` and ``or`` of conditions."""
        join = sympy.And if isinstance(node.op, ast.And) else sympy.Or
        return join(*(self.condition(value) for value in node.values))

    def visit_Call(self, node: ast.Call) -> Expr:
        """A function of :data:`FUNCTIONS`, a comparison by its SymPy name, or ``Piecewise``."""
        if not isinstance(node.func, ast.Name) or node.keywords:
            raise ModelError(f"expected the call of a named function, found {_short(_source(node))}")
        name = node.func.id
        if name == "Piecewise":
            if not node.args:
                raise ModelError("expected (value, condition) in Piecewise, found nothing")
            return sympy.Piecewise(*(self._piece(piece) for piece in node.args))
        arguments = [self.number(argument) for argument in node.args]
        if name in NAMED_COMPARISONS and len(arguments) == 2:
            return NAMED_COMPARISONS[name](*arguments)
        if name not in FUNCTIONS:
            raise UnknownNameError("function", name, (*FUNCTIONS, "Piecewise"))
        least, most = ARITY.get(name, (1, 1))
        if not least <= len(arguments) <= most:
            raise ModelError(f"wrong number of arguments for {name}: {_short(_source(node))}")
        return applied(FUNCTIONS[name], arguments)

    def _piece(self, node: ast.expr) -> tuple[Expr, Expr]:
        if not isinstance(node, ast.Tuple) or len(node.elts) != 2:
            raise ModelError(f"expected (value, condition) in Piecewise, found {_short(_source(node))}")
        value, condition = node.elts
        return self.number(value), self.condition(condition)


def _power(base: Expr, exponent: Expr) -> Expr:
    if base.is_Rational and exponent.is_Rational:
        size = max(abs(base.p), base.q).bit_length() * abs(exponent.p)
        if size > LARGEST_NUMBER_BITS or (base.p == 0 and exponent.p < 0):
            raise ModelError(f"expected a finite number, found {_short(f'{base}**{exponent}')}")
    return sympy.Pow(base, exponent)


OPERATORS: dict[type[ast.operator], Callable[[Expr, Expr], Expr]] = {
    ast.Add: sympy.Add,
    ast.Sub: lambda left, right: sympy.Add(left, product([sympy.S.NegativeOne, right])),
    ast.Mult: lambda left, right: product([left, right]),
    ast.Div: lambda left, right: product([left, _power(right, sympy.S.NegativeOne)]),
    ast.Pow: _power,
    ast.BitAnd: sympy.And,
    ast.BitOr: sympy.Or,
}


def _source(node: ast.AST) -> str:
    try:
        return ast.unparse(node)
    except (RecursionError, ValueError):
        return type(node).__name__
