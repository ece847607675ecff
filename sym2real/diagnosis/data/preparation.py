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
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.symbolic.period import at_period


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
    if dataset.dt < (1.0 - SETTINGS.time_step) * equations.dt:
        raise ShapeError(
            f"the model's time step is {equations.dt:g} s, the log's is {dataset.dt:g} s: read it with "
            f"dt={equations.dt:g}"
        )
    whole = None if isinstance(model, Equations) else model
    filtered = with_filtered_commands(equations, dataset)
    return MeasuredModel(at_period(equations, dataset.dt), model=whole), filtered


def with_filtered_commands(equations: Equations, dataset: Dataset) -> Dataset:
    """The logs with the commands that reach the robot when it delays, limits or smooths them as the equations say."""
    if not command_filters(equations):
        return dataset
    return Dataset(
        replace(
            trajectory, action=filter_commands(equations, torch.as_tensor(trajectory.action), dt=dataset.dt).numpy()
        )
        for trajectory in dataset
    )
