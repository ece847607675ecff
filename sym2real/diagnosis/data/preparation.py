"""Logs long enough, and equations made ready for predictions: hidden states start by themselves, filters act.

What is predicted is what is measured, so that a model with a tilted sensor board is held against its log fairly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import torch

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.filters import command_filters, filter_commands
from sym2real.effects.inputs import with_inputs
from sym2real.effects.sensors import MeasuredModel
from sym2real.effects.visible import VisibleModel, visible_in_double, visible_state
from sym2real.errors import ShapeError
from sym2real.logs.dropouts import LEFT_OUT
from sym2real.logs.equal_steps import equal_steps
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations, equations_of
from sym2real.symbolic.period import at_period, steps_within
from sym2real.trajectory import Array, Trajectory, require_finite


def with_columns(log: Trajectory, columns: dict[str, Array]) -> Trajectory:
    """The log with other values ``# (rows,)`` in columns of its three groups."""
    changed = {}
    for group in ("state", "action", "inputs"):
        layout, values = getattr(log.layouts, group), getattr(log, group).copy()
        for name in (name for name in columns if name in layout):
            values[:, layout.index(name)] = columns[name]
        changed[group] = values
    return replace(log, **changed)


def present(data: Dataset, columns: Sequence[str]) -> tuple[str, ...]:
    """Those of the columns that the logs have."""
    layouts = data.layouts
    return tuple(name for name in columns if name in layouts.state or name in layouts.action or name in layouts.inputs)


def long_enough(data: Logs, model: Equations | DynamicsModel | None = None) -> Dataset:
    """The logs that are longer than a window's history; the first of them notes which others were left out.

    Pieces between two gaps may be short; a noise or a time step cannot be told of a few rows.

    Args:
        data: logs.
        model: for which they are cut at gaps and brought to equal steps, as files are when they are read; None leaves
            them at their stamps.

    Raises:
        ShapeError: naming the logs, when none is long enough; naming log, row and column, for what is no finite number.
    """
    logs = [data] if isinstance(data, Trajectory) else list(data)
    for log in logs:
        require_finite(log)
    if model is not None:
        equations = equations_of(model)
        logs = [piece for log in logs for piece in equal_steps(log, equations.dt if equations else None)]
    kept, short = [log for log in logs if len(log) > ROWS], [log for log in logs if len(log) <= ROWS]
    if not kept:
        raise ShapeError(f"expected a log of more than {ROWS} rows without a gap, found {rows_of(short)}")
    if short:
        note = f"{LEFT_OUT}: {rows_of(short)}, where more than {ROWS} are needed"
        kept[0] = replace(kept[0], notes=(*kept[0].notes, note))
    return Dataset(kept)


def told_apart(data: Dataset) -> Dataset:
    """The logs with a name each, by which others are found for them; as they are where they have that.

    Logs without a name are named by their number, and of logs with one name the later ones have their number behind it.
    """
    names = list[str]()
    for number, log in enumerate(data, 1):
        name = log.name or f"log {number}"
        names.append(name if name not in names else f"{name} ({number})")
    if names == [log.name for log in data]:
        return data
    return Dataset(replace(log, name=name) for log, name in zip(data, names, strict=True))


def rows_of(logs: list[Trajectory]) -> str:
    """Every log with its number of rows, for a sentence."""
    return ", ".join(f"{len(log)} row{'s' if len(log) != 1 else ''} in {log.name or 'a log'}" for log in logs)


def prepared(model: Equations | DynamicsModel, dataset: Dataset) -> tuple[DynamicsModel, Dataset]:
    """The model to predict with, and the logs with its inputs and the commands that reach the robot.

    Raises:
        ShapeError: when columns or time steps differ.
    """
    equations = equations_of(model)
    if equations is None:
        return cast(DynamicsModel, model), dataset
    dataset = with_inputs(equations.layouts.inputs, dataset)
    wanted = replace(equations.layouts, state=visible_state(equations))
    if wanted != dataset.layouts:
        raise ShapeError(f"the model's columns are {wanted}, the log's are {dataset.layouts}")
    whole = None if isinstance(model, Equations) else model
    longer = dataset.dt / equations.dt - 1.0
    if longer < -SETTINGS.negligible or (whole is not None and longer > SETTINGS.same):
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
