"""What models predict along logs: from rows that were measured, under what reached the robot, as sensors report it.

What is predicted is what is measured, so that a model with a tilted sensor board is held against its log fairly.
"""

from dataclasses import replace
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from sym2real.dataset import Dataset
from sym2real.effects.filters import command_filters, filter_commands
from sym2real.effects.inputs import with_inputs
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import VisibleModel, hidden_rows, visible_in_double, visible_state
from sym2real.errors import ShapeError
from sym2real.past import past_rows
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations, equations_of, rollout
from sym2real.symbolic.period import at_period, steps_within
from sym2real.trajectory import Array, Trajectory

SAME_STEP = 0.01  # relative difference of a log's time step and a model's that are one


def predicted_from(
    model: DynamicsModel,
    log: Trajectory,
    rows: NDArray[np.int64],
    steps: int,
    *,
    start: Array | None = None,
    action: Tensor | None = None,
) -> Tensor:
    """States ``# (windows, steps, state)`` after rows of a log, in double precision.

    Args:
        model: predicts in its own precision. Hidden states go on along the log, and predictions start from what they
            are there; so does the past of a model that sees one.
        log: as the model takes it, see :func:`prepared`; behind its end its last row is held.
        rows: where predictions start ``# (windows,)``.
        steps: how far they go.
        start: states there ``# (windows, state)``; those measured by default.
        action: commands ``# (windows, steps, action)``; those of the log by default.
    """
    precision, seen = precision_of(model), past_rows(model)
    states, actions, inputs = (
        torch.as_tensor(values, dtype=precision) for values in (log.state, log.action, log.step_inputs)
    )
    ahead = np.minimum(rows[:, None] + np.arange(steps), len(log) - 1)
    begin = states[rows] if start is None else torch.as_tensor(start, dtype=precision)
    sent = actions[ahead] if action is None else action.to(precision)
    past = torch.as_tensor(log.past(*seen)[rows], dtype=precision) if any(seen) else None
    with torch.no_grad():
        hidden = hidden_rows(model, states, actions, inputs)[rows]
        return rollout(model, torch.cat([begin, hidden], dim=-1), sent, inputs[ahead], past=past).double()


def precision_of(model: object) -> torch.dtype:
    """Of a model's weights; double where it has none."""
    whole = model.model if isinstance(model, MeasuredModel) else model
    weights = (*whole.parameters(), *whole.buffers()) if isinstance(whole, nn.Module) else ()
    return next((weight.dtype for weight in weights if weight.is_floating_point()), torch.float64)


def prepared(
    model: Equations | DynamicsModel, dataset: Dataset, like: DynamicsModel | None = None
) -> tuple[DynamicsModel, Dataset]:
    """The model to predict with, and the logs with its inputs and the commands that reach the robot.

    Args:
        model: equations, or what predicts.
        dataset: logs.
        like: what was prepared of equations that differ in values of their parameters alone.

    Raises:
        ShapeError: when columns or time steps differ.
    """
    equations = equations_of(model)
    if equations is None:
        require_step(_step_of(model), dataset.dt)
        return cast(DynamicsModel, model), dataset
    dataset = with_inputs(equations.layouts.inputs, Dataset(in_columns_of(equations, log) for log in dataset))
    if equations.layouts.inputs != dataset.layouts.inputs:
        wanted, given = (" ".join(layouts.inputs) for layouts in (equations.layouts, dataset.layouts))
        raise ShapeError(f"expected logs with the model's inputs {wanted}, found {given or 'none'}")
    whole = None if isinstance(model, Equations) else model
    longer = dataset.dt / equations.dt - 1.0
    if longer < -SAME_STEP or (whole is not None and longer > SAME_STEP):
        raise ShapeError(
            f"the model's time step is {equations.dt:g} s, the log's is {dataset.dt:g} s: read it with "
            f"dt={equations.dt:g}{', upsample=True' if longer > 0.0 else ''}"
        )
    slow, logs = in_parts(equations, dataset)
    compiled = like.model if isinstance(like, MeasuredModel) and isinstance(like.model, VisibleModel) else None
    return MeasuredModel(slow, model=whole if compiled is None else compiled.at(slow)), logs


def _step_of(model: object) -> float:
    """Time step of a network in s; 0 where nobody says."""
    return float(getattr(getattr(model, "below", model), "dt", None) or 0.0)


def require_step(wanted: float, given: float) -> None:
    """Refuse logs of another time step than the model's; 0 is that of a model of which nobody says it.

    Raises:
        ShapeError: with both.
    """
    if wanted and abs(given / wanted - 1.0) > SAME_STEP:
        raise ShapeError(
            f"the model's time step is {wanted:g} s, the logs' is {given:g} s: read them with dt={wanted:g}"
        )


def in_columns_of(model: Equations | DynamicsModel, log: Trajectory) -> Trajectory:
    """A log in the columns of a model's equations; what else was measured and sent stands beside them, as in files.

    Raises:
        ShapeError: naming the columns that it lacks.
    """
    equations = equations_of(model)
    if equations is None:
        return log
    state, action = visible_state(equations), equations.layouts.action
    if (state, action) == (log.layouts.state, log.layouts.action):
        return log
    names = [*log.layouts.state, *log.layouts.action, *log.extra]
    if missing := [name for name in (*state, *action) if name not in (*names, *log.layouts.inputs)]:
        raise ShapeError(
            f"{log.name or 'a log'}: expected the model's columns {' '.join((*state, *action))}, found none called "
            f"{' '.join(missing)} among {' '.join(names)}"
        )
    between = log.between if {*action} <= {*log.layouts.action} else None
    if between is not None:
        between = between[:, :, log.layouts.action.indices(action)]
    return replace(
        log,
        state=np.stack([log.column(name) for name in state], axis=1),
        action=np.stack([log.column(name) for name in action], axis=1),
        layouts=replace(log.layouts, state=state, action=action),
        extra={name: log.column(name) for name in names if name not in state and name not in action},
        between=between,
    )


def from_row_to_row(model: Equations, data: Dataset) -> tuple[VisibleModel, Dataset] | None:
    """The equations over a step of the logs, and these with the inputs; None where they have other columns."""
    known = with_inputs(model.layouts.inputs, data)
    if replace(model.layouts, state=visible_state(model)) != known.layouts:
        return None
    return visible_in_double(at_period(model, data.dt)), known


def in_parts(equations: Equations, dataset: Dataset) -> tuple[Equations, Dataset]:
    """The equations from row to row, and the logs with what reaches the robot in every part of a row where it differs.

    Args:
        equations: of one step, whose filters the commands go through.
        dataset: logs with their columns, whose rows may be further apart.
    """
    logs = with_filtered_commands(equations, dataset)
    apart = any(log.between is not None for log in logs)
    slow = at_period(equations, dataset.dt, apart=apart)
    return slow, Dataset(_widened(log, slow) for log in logs) if apart else logs


def _widened(log: Trajectory, slow: Equations) -> Trajectory:
    parts = len(slow.layouts.action) // len(log.layouts.action)
    layouts = replace(log.layouts, action=slow.layouts.action)
    return replace(log, action=log.sent_in_parts(parts).reshape(len(log), -1), between=None, layouts=layouts)


def with_filtered_commands(equations: Equations, dataset: Dataset) -> Dataset:
    """The logs with the commands that reach the robot when it delays, limits or smooths them as the equations say.

    Of rows that are further apart than the equations' steps they are the means.
    """
    if not command_filters(equations):
        return dataset
    parts = steps_within(equations, dataset.dt)
    return Dataset(_filtered(equations, log, dataset.dt / parts, parts) for log in dataset)


def _filtered(equations: Equations, log: Trajectory, dt: float, parts: int) -> Trajectory:
    sent = torch.as_tensor(log.sent_in_parts(parts)).flatten(0, 1)
    reaching = filter_commands(equations, sent, dt=dt).numpy().reshape(len(log), parts, -1)
    return replace(log, action=reaching.mean(1), between=None if parts == 1 else reaching)
