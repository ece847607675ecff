"""What sensors report of a state column: the output that stands so far, and its replacement."""

from collections.abc import Mapping
from dataclasses import replace

from sympy import Expr

from sym2real.symbolic import Equations, symbol


def reported(equations: Equations, column: str) -> Expr:
    """What is measured of a state column."""
    return equations.output.get(column, symbol(column))


def reporting(equations: Equations, outputs: Mapping[str, Expr]) -> Equations:
    """The equations with other outputs; the motion is the same."""
    return replace(equations, output={**equations.output, **outputs})
