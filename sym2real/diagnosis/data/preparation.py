"""Equations and logs made ready for predictions: hidden states start by themselves, filters act on the commands.

What is predicted is what is measured, so that a model with a tilted sensor board is held against its log fairly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.filters import command_filters, filter_commands
from sym2real.effects.inputs import with_inputs
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import VisibleModel, visible_in_double, visible_state
from sym2real.errors import ShapeError
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.symbolic.period import at_period, steps_within
from sym2real.trajectory import Trajectory


def prepared(model: Equations | DynamicsModel, dataset: Dataset) -> tuple[DynamicsModel, Dataset]:
    """The model to predict with, and the logs with its inputs and the commands that reach the robot.

    Raises:
        ShapeError: when columns or time steps differ.
    """
    equations = model if isinstance(model, Equations) else getattr(model, "equations", None)
    if not isinstance(equations, Equations):
        return cast(DynamicsModel, model), dataset
    dataset = with_inputs(equations.layouts.inputs, dataset)
    wanted = replace(equations.layouts, state=visible_state(equations))
    if wanted != dataset.layouts:
        raise ShapeError(f"the model's columns are {wanted}, the log's are {dataset.layouts}")
    whole = None if isinstance(model, Equations) else model
    longer = dataset.dt / equations.dt - 1.0
    if longer < -SETTINGS.same or (whole is not None and longer > SETTINGS.same):
        raise ShapeError(
            f"the model's time step is {equations.dt:g} s, the log's is {dataset.dt:g} s: read it with "
            f"dt={equations.dt:g}{', upsample=True' if longer > 0.0 else ''}"
        )
    slow, logs = in_parts(equations, dataset)
    return MeasuredModel(slow, model=whole), logs


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
