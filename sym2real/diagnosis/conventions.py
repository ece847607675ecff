"""What stands in a log against the package's conventions beyond doubt: units, and the quaternion's order."""

from __future__ import annotations

from sym2real.diagnosis.command_units import foreign_commands
from sym2real.diagnosis.foreign_units import ForeignUnit, foreign_positions, foreign_rates, foreign_velocities
from sym2real.diagnosis.quaternion_order import ScalarLast, scalar_last
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

Breach = ForeignUnit | ScalarLast


def breaches(data: Dataset, model: Equations | None = None) -> tuple[list[Breach], Dataset]:
    """What is wrong, and the logs without it; units of commands only with a model that says what they do."""
    order = scalar_last(data)
    found: list[Breach] = [] if order is None else [order]
    data = data if order is None else order.undone(data)
    for look in (foreign_positions, foreign_velocities, foreign_rates):
        data = _without(found, look(data), data)
    if model is not None:
        data = _without(found, foreign_commands(model, data), data)
    return found, data


def _without(found: list[Breach], more: list[ForeignUnit], data: Dataset) -> Dataset:
    found += more
    for one in more:
        data = one.undone(data)
    return data
