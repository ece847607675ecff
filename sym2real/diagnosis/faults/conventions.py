"""What stands in a log against the package's conventions beyond doubt: units, quaternions' order, commands' signs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.command_units import foreign_commands
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.faults.misread_attitudes import Misread, against_the_path, other_angles, scalar_last
from sym2real.diagnosis.faults.mistakes import BadRows, Undoing, bad_rows, mistakes
from sym2real.symbolic import Equations

Breach = ForeignUnit | Misread | BadRows | Undoing
Look = Callable[[Dataset], Sequence[Breach]]


def looks_for(model: Equations | None) -> tuple[tuple[Look, ...], ...]:
    """What is looked for, in order, with this model or without one.

    First rows, quaternions (one in another order is no turned or mirrored world), units of what sensors measure, those
    of commands, with which a model predicts nothing that columns could be judged by, and what a user has done to
    columns. Then units again, as a turned frame hid them, and again what was done to columns: once those have their
    units and signs, more can be seen.
    """
    frames = (bad_rows, scalar_last, other_angles)
    units = (foreign_positions, foreign_velocities, foreign_rates)
    if model is None:
        return (*frames, against_the_path), units, ()
    mistaken, commands = partial(mistakes, model), partial(foreign_commands, model)
    return (*frames, *units, commands, mistaken, against_the_path), units, (commands, mistaken)


def undone(breaches: Sequence[Breach], data: Dataset) -> Dataset:
    """The logs without what was found in them."""
    for breach in breaches:
        data = breach.undone(data)
    return data


def through(sensors: Callable[[Tensor], Tensor], data: Dataset) -> Dataset:
    """The logs with states as sensors report them, or the other way."""
    return Dataset(replace(log, state=sensors(torch.as_tensor(log.state)).numpy()) for log in data)
