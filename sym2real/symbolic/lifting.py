"""Numbers of equations as parameters, so that a fit may move them."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, count

import sympy
from sympy import Expr

from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import symbol


def constants(equations: Equations) -> Iterator[float]:
    """Values of what :func:`lift_constants` makes parameters, in order of appearance."""
    for expression in chain(equations.next.values(), equations.quantities.values()):
        yield from _floats(expression)


def lift_constants(equations: Equations) -> Equations:
    """Every float of ``next`` and ``quantities`` as a parameter c0, c1, …, in order of appearance.

    Exact integers and rationals are structure (the 2 of 1 − 2·qx²) and stay; so do exponents.
    """
    taken = frozenset(equations.names)
    free = (name for name in map("c{}".format, count()) if name not in taken)
    values = dict(zip(free, list(constants(equations)), strict=False))
    names = iter(values)
    following = {column: _lifted(expression, names) for column, expression in equations.next.items()}
    quantities = {name: _lifted(expression, names) for name, expression in equations.quantities.items()}
    return replace(equations, next=following, quantities=quantities, parameters={**equations.parameters, **values})


def _floats(expression: Expr) -> Iterator[float]:
    if isinstance(expression, sympy.Float):
        yield float(expression)
    for argument in expression.args[:1] if isinstance(expression, sympy.Pow) else expression.args:
        yield from _floats(argument)


def _lifted(expression: Expr, names: Iterator[str]) -> Expr:
    if isinstance(expression, sympy.Float):
        return symbol(next(names))
    if not expression.args:
        return expression
    if isinstance(expression, sympy.Pow):
        return sympy.Pow(_lifted(expression.base, names), expression.exp)
    return expression.func(*(_lifted(argument, names) for argument in expression.args))
