"""Numbers of equations as parameters, so that a fit may move them."""

from collections.abc import Collection
from dataclasses import replace
from itertools import count

import sympy
from sympy import Expr

from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import symbol


def lift_constants(equations: Equations) -> Equations:
    """Every float of ``next`` and ``quantities`` as a parameter c0, c1, …, in order of appearance.

    Exact integers and rationals are structure (the 2 of 1 − 2·qx²) and stay; so do exponents.
    """
    values, taken = dict(equations.parameters), frozenset(equations.names)
    following = {name: _lifted(expression, values, taken) for name, expression in equations.next.items()}
    quantities = {name: _lifted(expression, values, taken) for name, expression in equations.quantities.items()}
    return replace(equations, next=following, quantities=quantities, parameters=values)


def _lifted(expression: Expr, values: dict[str, float], taken: Collection[str]) -> Expr:
    if isinstance(expression, sympy.Float):
        name = next(name for name in map("c{}".format, count()) if name not in values and name not in taken)
        values[name] = float(expression)
        return symbol(name)
    if not expression.args:
        return expression
    if isinstance(expression, sympy.Pow):
        return sympy.Pow(_lifted(expression.base, values, taken), expression.exp)
    return expression.func(*(_lifted(argument, values, taken) for argument in expression.args))
