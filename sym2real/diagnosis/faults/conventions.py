"""What stands in a log against the package's conventions beyond doubt: units, quaternions' order, commands' signs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import torch
from torch import Tensor

from sym2real.diagnosis.faults.command_signs import ReversedCommand, reversed_commands
from sym2real.diagnosis.faults.command_units import foreign_commands
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.faults.mistakes import BadRows, Undoing, bad_rows, mistakes
from sym2real.diagnosis.faults.quaternion_order import ScalarLast, scalar_last
from sym2real.effects.sensors import Sensors
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

Breach = ForeignUnit | ScalarLast | ReversedCommand | BadRows | Undoing
Look = Callable[[Dataset], Sequence[Breach]]


def unless_healthy(look: Look) -> Look:
    """The look, which is not repeated at logs that it has found nothing in."""
    healthy: list[Dataset] = []

    def looked(data: Dataset) -> Sequence[Breach]:
        if any(data is one for one in healthy):
            return ()
        found = look(data)
        if not found:
            healthy.append(data)
        return found

    return looked


def breaches(data: Dataset, model: Equations | None = None) -> tuple[list[Breach], Dataset]:
    """What is wrong, and the logs without it; commands are judged only with a model that says what they do.

    What the model says of its sensors is no breach: the logs come back as their sensors' input.
    """
    if model is not None:
        data = through(Sensors(model).state, data)
    found: list[Breach] = []
    looks: list[Look] = [bad_rows, scalar_last, foreign_positions, foreign_velocities, foreign_rates]
    if model is not None:
        mistaken = unless_healthy(partial(mistakes, model))
        commands = (partial(foreign_commands, model), mistaken, partial(reversed_commands, model))
        # A quaternion in another order is no turned or mirrored world.
        looks = [*looks[:2], mistaken, *looks[2:], *commands]
    for look in looks:
        more = look(data)
        data, found = undone(more, data), [*found, *more]
    return found, data


def undone(found: Sequence[Breach], data: Dataset) -> Dataset:
    """The logs without what was found in them."""
    for one in found:
        data = one.undone(data)
    return data


def through(sensors: Callable[[Tensor], Tensor], data: Dataset) -> Dataset:
    """The logs with states as sensors report them, or the other way."""
    return Dataset(replace(log, state=sensors(torch.as_tensor(log.state)).numpy()) for log in data)
