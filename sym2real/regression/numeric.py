"""Values of equations on the rows of transitions, in double precision."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import sympy
import torch

from sym2real.dataset import Transitions
from sym2real.symbolic import Equations, symbol
from sym2real.trajectory import Array


def columns_of(transitions: Transitions) -> dict[str, Array]:
    """Every column of state, action and inputs by name ``# (rows,)``."""
    layouts = transitions.layouts
    groups = (
        (layouts.state, transitions.state),
        (layouts.action, transitions.action),
        (layouts.inputs, transitions.inputs),
    )
    return {column: values[:, position] for layout, values in groups for position, column in enumerate(layout)}


def resolved(equations: Equations, column: str) -> sympy.Expr:
    """The equation of a state column with quantities and parameters put in."""
    expression = equations.next[column]
    quantities = {symbol(name): value for name, value in equations.quantities.items()}
    while expression.free_symbols & quantities.keys():
        expression = expression.xreplace(quantities)
    return expression.xreplace({symbol(name): sympy.Float(value) for name, value in equations.parameters.items()})


def evaluate(expression: sympy.Expr, columns: Mapping[str, Array]) -> Array:
    """Values of an expression ``# (rows,)``."""
    names = sorted(used.name for used in expression.free_symbols)
    # SymPy writes source and executes it: with names of its own, not those of a log.
    function = sympy.lambdify([symbol(name) for name in names], expression, "numpy", dummify=True)
    with np.errstate(all="ignore"):
        values = np.asarray(function(*(columns[name] for name in names)), dtype=np.float64)
    rows = len(next(iter(columns.values())))
    return np.broadcast_to(values, (rows,))


def one_step_errors(equations: Equations, transitions: Transitions) -> dict[str, Array]:
    """True minus predicted next value of every state column ``# (rows,)``; predictions are put on the manifold."""
    columns, state = columns_of(transitions), transitions.layouts.state
    predicted = np.stack([evaluate(resolved(equations, column), columns) for column in state], axis=1)
    wrong = transitions.next_state - state.normalise(torch.tensor(predicted)).numpy()
    return dict(zip(state, wrong.T, strict=True))


def fit_quality(equations: Equations, transitions: Transitions) -> dict[str, float]:
    """Root mean square one-step error of every state column, in its unit, whatever engine made the equations."""
    return {
        column: float(np.sqrt(np.mean(wrong**2))) for column, wrong in one_step_errors(equations, transitions).items()
    }
