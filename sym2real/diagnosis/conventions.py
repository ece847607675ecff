"""What stands in a log against the package's conventions beyond doubt: units, quaternions' order, commands' signs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from sym2real.diagnosis.command_signs import ReversedCommand, reversed_commands
from sym2real.diagnosis.command_units import foreign_commands
from sym2real.diagnosis.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.quaternion_order import ScalarLast, scalar_last
from sym2real.effects.sensors import Sensors
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

Breach = ForeignUnit | ScalarLast | ReversedCommand


def breaches(data: Dataset, model: Equations | None = None) -> tuple[list[Breach], Dataset]:
    """What is wrong, and the logs without it; units of commands only with a model that says what they do.

    What the model says of its sensors is no breach: the logs come back as their sensors' input.
    """
    if model is not None:
        sensors = Sensors(model)
        data = Dataset(replace(log, state=sensors.state(torch.as_tensor(log.state)).numpy()) for log in data)
    order = scalar_last(data)
    found: list[Breach] = [] if order is None else [order]
    data = data if order is None else order.undone(data)
    for look in (foreign_positions, foreign_velocities, foreign_rates):
        data = _without(found, look(data), data)
    if model is not None:
        for judge in (foreign_commands, reversed_commands):
            data = _without(found, judge(model, data), data)
    return found, data


def _without(found: list[Breach], more: Sequence[Breach], data: Dataset) -> Dataset:
    found += more
    for one in more:
        data = one.undone(data)
    return data
