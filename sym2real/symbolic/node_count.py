"""Nodes of an expression as a binary tree: every operator, variable and constant is 1 (PySR's count).

``x**n`` counts as n − 1 products of n copies of x; ``a - b`` and ``a/b`` are one operator; a negative
coefficient is one constant.
"""

import sympy
from sympy import Expr


def complexity(expression: Expr) -> int:
    """Number of nodes of the binary tree."""
    if expression.is_Add:
        return _sum(expression)
    if expression.is_Mul:
        return _product(expression)
    if expression.is_Pow and expression.base is not sympy.E:
        return _power(expression)
    if not expression.args or (expression.is_number and expression.is_Rational):
        return 1
    if isinstance(expression, sympy.Piecewise):
        return _piecewise(expression)
    operators = max(len(expression.args) - 1, 1)  # Min, Max, And, Or take any number of arguments
    return operators + sum(complexity(argument) for argument in expression.args)


def _sum(expression: Expr) -> int:
    total, can_lead = len(expression.args) - 1, False
    for term in expression.args:
        coefficient, rest = term.as_coeff_Mul()
        subtracted = coefficient == -1 and rest is not sympy.S.One
        can_lead |= not subtracted
        total += complexity(rest if subtracted else term)
    return total if can_lead else total + 2  # −a − b is (−1)*a − b


def _product(expression: Expr) -> int:
    above, below = [], []
    for factor in expression.args:
        if factor.is_Pow and factor.exp.is_Rational and factor.exp.is_negative:
            below.append(complexity(1 / factor))
        else:
            above.append(complexity(factor))
    return sum(above) + sum(below) + len(above) + len(below) - (1 if above else 0)


def _power(expression: Expr) -> int:
    base, exponent = expression.args
    if exponent.is_Rational and exponent.is_negative:
        return 2 + complexity(1 / expression)
    cost = complexity(base)
    if exponent == sympy.Rational(1, 2):
        return 1 + cost
    if float(exponent).is_integer() if exponent.is_Number else False:
        copies = int(exponent)
        return copies * cost + copies - 1
    return 1 + cost + complexity(exponent)


def _piecewise(expression: Expr) -> int:
    total = 0
    for value, condition in expression.args:
        total += complexity(value)
        if condition != sympy.true:
            total += 1 + complexity(condition)
    return total
