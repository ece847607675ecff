"""How expressions are made, named and written: symbols, the functions that exist, products that stay factored.

SymPy multiplies a number into a sum (``2*(x + y)`` becomes ``2*x + 2*y``), which costs operations and undoes
factoring. :func:`product` keeps such products as they are; :func:`exchange` and the parser use it.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import sympy
from sympy import Expr, Symbol
from sympy.printing.str import StrPrinter

from sym2real.errors import ModelError
from sym2real.field import is_name
from sym2real.registry import Registry
from sym2real.symbolic.elementary import ELEMENTARY, WRITTEN_OUT
from sym2real.symbolic.shared_parts import Exchange, distinct, remembered

_CLASSES = (*(function.of for function in ELEMENTARY.values()), *WRITTEN_OUT, sympy.Min, sympy.Max)
FUNCTIONS: Registry[type] = Registry(
    "function", {"sqrt": sympy.sqrt, "abs": sympy.Abs, **{kind.__name__: kind for kind in _CLASSES}}
)
CONSTANTS: Mapping[str, Expr] = {"pi": sympy.pi, "E": sympy.E}
NOT_FINITE_OR_REAL = frozenset({sympy.I, sympy.nan, sympy.oo, -sympy.oo, sympy.zoo})


def require_names(names: Sequence[str]) -> None:
    """Refuse names that cannot stand in an expression, or that stand for two things.

    Raises:
        ModelError: with the name.
    """
    for name, count in Counter(names).items():
        if not is_name(name) or name in CONSTANTS:
            raise ModelError(f"expected a name that can stand in an expression, found {name!r}")
        if count > 1:
            raise ModelError(f"the name {name!r} stands for two things: columns, quantities and parameters share names")


def symbol(name: str) -> Symbol:
    """The one way symbols are made: real, so that two symbols of one name are equal."""
    return Symbol(name, real=True)


def product(factors: Iterable[Expr]) -> Expr:
    """Product of the factors; a number times a sum stays a product."""
    number, others = sympy.S.One, []
    for factor in factors:
        coefficient, rest = factor.as_coeff_Mul()
        number *= coefficient
        if rest is not sympy.S.One:
            others.append(rest)
    rest = sympy.Mul(*others)
    if rest.is_Add and number not in (0, 1):
        return sympy.Mul(number, rest, evaluate=False)
    return sympy.Mul(number, rest)


def rebuild(expression: Expr, arguments: Iterable[Expr]) -> Expr:
    """The same operation on other arguments, factored products kept."""
    if expression.is_Mul:
        return product(arguments)
    return applied(expression.func, list(arguments))


def applied(function: type, arguments: Sequence[Expr]) -> Expr:
    """A function of arguments."""
    if function in (sympy.Min, sympy.Max):
        # SymPy compares every two arguments by factoring them, for seconds where they are equations.
        return function(*arguments, evaluate=all(argument.is_number for argument in arguments))
    return function(*arguments)


def exchange(replacements: Mapping[Expr, Expr]) -> Exchange:
    """Replaces parts of expressions at once; a replacement may contain the symbols that are replaced."""
    return Exchange(replacements, rebuild)


def canonical(expression: Expr | float | int) -> Expr:
    """The expression over :func:`symbol` symbols and 53-bit floats.

    Raises:
        ModelError: when it is not a real scalar expression.
    """
    try:
        expression = sympy.sympify(expression, strict=True)
    except (sympy.SympifyError, TypeError) as error:
        raise ModelError(f"expected a SymPy expression or a number, found {expression!r}") from error
    return _canonical(expression)


@remembered
def names_in(expression: Expr) -> frozenset[str]:
    """Names of the symbols of an expression."""
    return frozenset(part.name for part in distinct(expression) if part.is_Symbol)


@remembered
def _canonical(expression: Expr) -> Expr:
    changes: dict[Expr, Expr] = {}
    for part in distinct(expression):
        if part in NOT_FINITE_OR_REAL:
            raise ModelError(f"expected a finite real expression, found {expression}")
        if part.is_Symbol and part != symbol(part.name):
            changes[part] = symbol(part.name)
        elif part.is_Float and part._prec != 53:
            changes[part] = sympy.Float(float(part))
        elif isinstance(part, sympy.ITE):  # SymPy folds nested cases into if-then-else; and, or, not say the same
            changes[part] = part.to_nnf()
    return exchange(changes)(expression) if changes else expression


class _ExactPrinter(StrPrinter):  # type: ignore[misc]  # SymPy has no types
    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802  # SymPy's naming
        return repr(float(expr))


def text(expression: Expr) -> str:
    """One line that :func:`sym2real.symbolic.parsing.parse_expression` reads back without loss."""
    return str(_ExactPrinter({"full_prec": False}).doprint(expression))
