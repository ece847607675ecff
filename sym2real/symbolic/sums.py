"""Equations with something added to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sympy import Expr

from sym2real.symbolic.equations import Equations


def with_added(equations: Equations, expressions: Mapping[str, Expr]) -> Equations:
    """Equations whose next states have expressions added, before they are put back on the manifold.

    Args:
        equations: stay as they are.
        expressions: state column → what is added to its next value.

    Raises:
        UnknownNameError: for a column that is no state, or a name in an expression that the equations do not have.
    """
    for column in expressions:
        equations.layouts.state.index(column)
    return replace(equations, next={c: value + expressions.get(c, 0) for c, value in equations.next.items()})
