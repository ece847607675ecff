"""What stands in a log against the package's conventions beyond doubt: units, quaternions' order, commands' signs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.command_units import foreign_commands
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.faults.mistakes import BadRows, Undoing, bad_rows, mistakes
from sym2real.diagnosis.faults.quaternion_order import ScalarLast, scalar_last
from sym2real.symbolic import Equations

Breach = ForeignUnit | ScalarLast | BadRows | Undoing
Look = Callable[[Dataset], Sequence[Breach]]


@dataclass(frozen=True)
class Looks:
    """What is looked for, in order: a quaternion in another order is no turned or mirrored world.

    Args:
        frames: rows, quaternions, units of what sensors measure, and with a model what a user has done to columns.
        units: again, as a turned frame hid them.
        commands: their units, which only a model can judge, and again what was done to columns.
    """

    frames: tuple[Look, ...]
    units: tuple[Look, ...]
    commands: tuple[Look, ...] = ()

    @classmethod
    def of(cls, model: Equations | None) -> Looks:
        """All that can be looked for with this model, or without one."""
        frames = (bad_rows, scalar_last)
        units = (foreign_positions, foreign_velocities, foreign_rates)
        if model is None:
            return cls(frames, units)
        # Once columns have their units and signs, what was hidden before can be seen.
        mistaken = partial(mistakes, model)
        return cls((*frames, *units, mistaken), units, (partial(foreign_commands, model), mistaken))


def undone(breaches: Sequence[Breach], data: Dataset) -> Dataset:
    """The logs without what was found in them."""
    for breach in breaches:
        data = breach.undone(data)
    return data


def through(sensors: Callable[[Tensor], Tensor], data: Dataset) -> Dataset:
    """The logs with states as sensors report them, or the other way."""
    return Dataset(replace(log, state=sensors(torch.as_tensor(log.state)).numpy()) for log in data)
