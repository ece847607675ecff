"""What logs hold of the commands that effects are bound to."""

from __future__ import annotations

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.effects import Effect
from sym2real.effects.filters import spelled_out
from sym2real.symbolic import Equations, compile_function
from sym2real.symbolic.expressions import names_in
from sym2real.trajectory import Array, Trajectory

# Commands are as sent, without noise: one that varies less shows nothing of its map.
STILL = 1e-9


def values_for(equations: Equations, effect: Effect, data: Dataset) -> Array:
    """Values of the command that an effect is bound to in all logs ``# (rows,)``; none for an effect of no column."""
    if not effect.column or effect.of.columns != "action":
        return np.zeros(0)
    return np.concatenate([column_values(equations, effect.column, trajectory) for trajectory in data])


def still(equations: Equations, effect: Effect, data: Dataset) -> str:
    """Which command would have to vary for an effect to show, and never does, for a sentence; "" where it does."""
    needed = (effect.column,) if effect.column else effect.searching.varying
    for name in needed:
        if name in (*data.layouts.action, *equations.quantities) and not _varies(equations, name, data):
            return f"{name} never varies in these logs"
    if effect.of.columns == "action" and not any(_varies(equations, name, data) for name in data.layouts.action):
        return "no command varies in these logs"
    return ""


def _varies(equations: Equations, name: str, data: Dataset) -> bool:
    values = np.concatenate([column_values(equations, name, trajectory) for trajectory in data])
    return float(np.std(values)) >= STILL


def column_values(equations: Equations, name: str, trajectory: Trajectory) -> Array:
    """A column of a log, or a quantity that the equations derive from its columns ``# (rows,)``."""
    if name not in equations.quantities:
        return trajectory.column(name)
    expression = spelled_out(equations, equations.quantities[name])
    columns = sorted(names_in(expression))
    rows = torch.as_tensor(np.stack([trajectory.column(column) for column in columns], axis=1))
    derived: Array = compile_function([expression], [columns])(rows)[:, 0].numpy()
    return derived
