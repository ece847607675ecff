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
from sym2real.effects.visible import visible_state
from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.symbolic.period import at_period, steps_within


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
    if longer < -SETTINGS.time_step or (whole is not None and longer > SETTINGS.time_step):
        raise ShapeError(
            f"the model's time step is {equations.dt:g} s, the log's is {dataset.dt:g} s: read it with "
            f"dt={equations.dt:g}{', upsample=True' if longer > 0.0 else ''}"
        )
    apart = bool(command_filters(equations)) and whole is None
    slow = at_period(equations, dataset.dt, apart=apart)
    parts = steps_within(equations, dataset.dt) if apart else 1
    return MeasuredModel(slow, model=whole), with_filtered_commands(equations, dataset, slow.layouts, parts)


def with_filtered_commands(
    equations: Equations, dataset: Dataset, layouts: Layouts | None = None, parts: int = 1
) -> Dataset:
    """The logs with the commands that reach the robot when it delays, limits or smooths them as the equations say.

    Args:
        equations: with filters.
        dataset: logs, whose rows may be further apart than the equations' steps.
        layouts: with the commands of every part of a row; those of the logs by default.
        parts: of a row.
    """
    if not command_filters(equations):
        return dataset
    action = layouts.action if layouts else dataset.layouts.action
    return Dataset(
        replace(
            log,
            action=filter_commands(equations, torch.as_tensor(log.action), dt=dataset.dt, parts=parts).numpy(),
            layouts=replace(log.layouts, action=action),
        )
        for log in dataset
    )
