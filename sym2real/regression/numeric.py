"""Values of equations on the rows of transitions, in double precision."""

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.errors import ShapeError
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Array


def columns_of(transitions: Transitions) -> dict[str, Array]:
    """Every column of state, action and inputs by name ``# (rows,)``."""
    layouts = transitions.layouts
    table = np.concatenate([transitions.state, transitions.action, transitions.inputs], axis=1)
    return dict(zip((*layouts.state, *layouts.action, *layouts.inputs), table.T, strict=True))


def operands(equations: Equations, columns: Mapping[str, Array]) -> list[Tensor]:
    """State, action and inputs as a compiled model takes them ``# (rows, …)``, by name from columns ``# (rows,)``.

    Raises:
        ShapeError: naming columns of the equations that are not there, such as hidden states, which no log holds.
    """
    layouts, rows = equations.layouts, len(next(iter(columns.values())))
    groups = (layouts.state, layouts.action, layouts.inputs)
    missing = [name for group in groups for name in group if name not in columns]
    if missing:
        raise ShapeError(f"expected rows with every column of the equations, found none of {', '.join(missing)}")
    return [torch.tensor(np.array([columns[name] for name in group]).reshape(len(group), rows).T) for group in groups]


def one_step_errors(equations: Equations, transitions: Transitions) -> dict[str, Array]:
    """True minus predicted next value of every state column ``# (rows,)``; predictions are put on the manifold."""
    given = operands(equations, columns_of(transitions))
    predicted: Tensor = compile_model(equations, dtype=torch.float64)(*given)
    wrong = transitions.next_state - predicted.detach().numpy()
    return dict(zip(transitions.layouts.state, wrong.T, strict=True))


def fit_quality(equations: Equations, transitions: Transitions) -> dict[str, float]:
    """Root mean square one-step error of every state column, in its unit, whatever engine made the equations."""
    return {
        column: float(np.sqrt(np.mean(wrong**2))) for column, wrong in one_step_errors(equations, transitions).items()
    }
