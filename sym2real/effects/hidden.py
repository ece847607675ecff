"""States that a log does not hold."""

from dataclasses import replace

from sympy import Expr

from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.symbolic import Equations


def with_hidden(equations: Equations, name: str, unit: str, following: Expr, start: Expr) -> Equations:
    """The equations with one more state, last and hidden: what follows it, and its first value."""
    field = Field(name.replace("_", " "), (name,), unit, "body", hidden=True)
    return replace(
        equations,
        layouts=replace(equations.layouts, state=equations.layouts.state + Layout((field,))),
        next={**equations.next, name: following},
        start={**equations.start, name: start},
    )
