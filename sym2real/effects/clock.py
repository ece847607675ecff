"""Time as an input of equations."""

from dataclasses import replace

from sympy import Expr

from sym2real.layout import Layout
from sym2real.symbolic import Equations, symbol


def with_time(equations: Equations) -> tuple[Equations, Expr]:
    """The equations with the input ``t`` (s since the recording began), last where they had none; mid-step time."""
    if "t" not in equations.layouts.inputs:
        inputs = equations.layouts.inputs + Layout.of(("t",))
        equations = replace(equations, layouts=replace(equations.layouts, inputs=inputs))
    return equations, symbol("t") + equations.dt / 2
