"""Do the actions reach the states that they must? A model that misses one cannot be steered by it.

The score of a pair is how much of a state's spread an action moves by itself within one step:

    score = rms(∂Δs_i/∂a_j) · std(a_j) / std(Δs_i)

with the derivative of the equations taken exactly and the statistics over the training rows.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import torch

from sym2real.dataset import Transitions
from sym2real.errors import ModelError
from sym2real.regression.numeric import columns_of, operands
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Array

BAR = 0.005
LIFT = ("vz", "thrust")


@dataclass(frozen=True)
class Dependence:
    """One row of the table.

    Args:
        state: state column.
        action: action column that must reach it.
        score: share of the state's spread that the action moves; NaN where the data cannot tell, because the
            action or the state never changes.
        bar: what the score must exceed.
        holds: whether it does.
        meaning: what was computed.
    """

    state: str
    action: str
    score: float
    bar: float
    holds: bool
    meaning: str = "rms of ∂Δs/∂a · std(a)/std(Δs)"


def dependence(
    equations: Equations, transitions: Transitions, pairs: Iterable[tuple[str, str]]
) -> tuple[Dependence, ...]:
    """Table of the pairs (state column, action column), and of the lift at hover where the columns are there.

    Raises:
        UnknownNameError: when a pair names a column that does not exist.
    """
    table = [_pair(equations, transitions, state, action) for state, action in pairs]
    if LIFT[0] in equations.layouts.state and LIFT[1] in equations.layouts.action:
        table.append(_lift_at_hover(equations, transitions))
    return tuple(table)


def require_dependence(
    equations: Equations, transitions: Transitions, pairs: Iterable[tuple[str, str]]
) -> tuple[Dependence, ...]:
    """The table of :func:`dependence`, if every pair in it holds.

    Raises:
        ModelError: when one does not, with what to do about it.
    """
    table = dependence(equations, transitions, pairs)
    missing = [row for row in table if not row.holds]
    if missing:
        weak = "; ".join(f"{row.action} → {row.state}: {row.score:.2g} ({row.meaning})" for row in missing)
        raise ModelError(
            f"the equations cannot be steered: expected every score above its bar ({BAR:g}; 0 for the lift at hover), "
            f"found {weak}. Vary {' and '.join(sorted({row.action for row in missing}))} more in the training "
            "trajectories (random commands held for 0.2 s), add trajectories, or learn from the noise-free simulator "
            "instead of recorded logs"
        )
    return table


def _pair(equations: Equations, transitions: Transitions, state: str, action: str) -> Dependence:
    row = equations.layouts.state.index(state)
    sent = transitions.action[:, equations.layouts.action.index(action)]
    moved = transitions.next_state[:, row] - transitions.state[:, row]
    slope = _slope(equations, state, action, columns_of(transitions))
    if np.ptp(sent) == 0.0 or np.ptp(moved) == 0.0:
        return Dependence(state, action, float("nan"), BAR, False)
    score = float(np.sqrt(np.mean(slope**2)) * sent.std() / moved.std())
    return Dependence(state, action, score, BAR, score > BAR)


def _lift_at_hover(equations: Equations, transitions: Transitions) -> Dependence:
    """∂vz′/∂thrust upright and at rest, at the mean command of the rows, without a wrench."""
    layouts = transitions.layouts
    at = dict.fromkeys(equations.columns, np.zeros(1))
    for field in layouts.state.fields + layouts.inputs.fields:
        if field.kind == "quaternion":
            at[field.columns[0]] = np.ones(1)
    action = transitions.action.mean(axis=0, keepdims=True)
    at |= {column: action[:, position] for position, column in enumerate(layouts.action)}
    for column in ("x", "y", "z"):
        if column in layouts.state:
            at[column] = transitions.state[:, layouts.state.index(column)].mean(keepdims=True)
    slope = float(_slope(equations, *LIFT, at)[0])
    return Dependence(*LIFT, slope, 0.0, slope > 0.0, "∂vz′/∂thrust at hover, (m/s)/N")


def _slope(equations: Equations, state: str, action: str, columns: dict[str, Array]) -> Array:
    """∂s_i′/∂a_j ``# (rows,)``, by automatic differentiation: equations of many quantities have no short derivative."""
    layouts, values = equations.layouts, operands(equations, columns)
    values[1].requires_grad_(True)
    following = compile_model(equations, dtype=torch.float64)(*values)
    total = following[..., layouts.state.index(state)].sum()
    if not total.requires_grad:
        return np.zeros(len(values[1]))
    (slope,) = torch.autograd.grad(total, values[1])
    return np.asarray(slope[:, layouts.action.index(action)].numpy(), dtype=np.float64)
