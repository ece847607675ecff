"""Columns in another unit than the vocabulary's, known by how many times too large they are: deg/s, mm, cm/s.

What is measured twice tells: rates against the attitude that they turn, velocities against the position that they move,
and how a quadrotor is pushed aside against where its thrust points. A factor of a few may be a robot's own.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, log
from statistics import median

import numpy as np

from sym2real.diagnosis.agreement import AGREES, Agreement, rate_agreement, thrust_agreement, velocity_agreement
from sym2real.logs.units import UNITS, standard_unit
from sym2real.trajectory import Dataset, Trajectory

LARGE = 3.0  # times; less is no other unit
NEAR = 1.25  # times; a unit is named where the factor is as near to its own


@dataclass(frozen=True)
class ForeignUnit:
    """Columns that are not in the unit that they stand for.

    Args:
        columns: of the state or the action.
        ratio: what is logged over what is meant, as found.
        unit: key of :data:`~sym2real.logs.units.UNITS`; "" where none has such a factor.
        factor: what is logged over what is meant, of that unit; as found where there is none.
        than: what they are so many times, for a sentence.
    """

    columns: tuple[str, ...]
    ratio: float
    unit: str
    factor: float
    than: str

    @property
    def evidence(self) -> str:
        """What shows it, one clause."""
        meant, names = standard_unit(self.columns[0]), " ".join(self.columns)
        told = f"{self.unit} instead of {meant}" if self.unit else f"no unit of {meant} that is known"
        return f"{names} in {told}: the logged numbers are {_plain(self.ratio)} times {self.than}"

    @property
    def fix(self) -> str:
        """What to change."""
        column = self.columns[0]
        value = f'unit = "{self.unit}"' if self.unit else f"scale = {1.0 / self.factor:.4g}"
        return f'say so in a specification of the log, as in {column} = {{ column = "{column}", {value} }}'

    def undone(self, data: Dataset) -> Dataset:
        """The logs with these columns in the unit that is meant."""
        return Dataset(self._undone(one) for one in data)

    def _undone(self, one: Trajectory) -> Trajectory:
        state, action = one.state.copy(), one.action.copy()
        for values, layout in ((state, one.layouts.state), (action, one.layouts.action)):
            values[:, layout.indices([name for name in self.columns if name in layout])] /= self.factor
        return replace(one, state=state, action=action)


def named(columns: Sequence[str], ratio: float, than: str) -> ForeignUnit:
    """Columns that are so many times too large, with the unit that is nearest."""
    known = factors(columns[0])
    unit = min(known, key=lambda one: abs(log(known[one] / ratio)), default="")
    if not unit or abs(log(known[unit] / ratio)) > log(NEAR):
        return ForeignUnit(tuple(columns), ratio, "", ratio, than)
    return ForeignUnit(tuple(columns), ratio, unit, known[unit], than)


def factors(column: str, mass: float | None = None) -> dict[str, float]:
    """Unit → how many times larger its numbers are than the column's own, of those that are far larger.

    Args:
        column: standard column name.
        mass: kg, where a thrust may be logged per unit mass.
    """
    meant = standard_unit(column)
    found = {unit: 1.0 / value for unit, (inside, value) in UNITS.items() if inside == meant}
    if meant == "N" and mass is not None:
        found |= {unit: 1.0 / (value * mass) for unit, (inside, value) in UNITS.items() if inside == "m/s^2"}
    return {unit: value for unit, value in found.items() if value >= LARGE}


def foreign_positions(data: Dataset) -> list[ForeignUnit]:
    """The position, by a quadrotor's pushes or by the velocity that it should have."""
    columns = [name for name in ("x", "y", "z") if name in data.layouts.state]
    pushed = thrust_agreement(list(data))
    ratio = _ratio([pushed])
    if ratio is not None and ratio >= LARGE:
        return [named(columns, ratio, "how far thrust moves the robot")]
    ratio = _ratio(velocity_agreement(list(data)).values())
    if ratio is not None and 1.0 / ratio >= LARGE:
        return [named(columns, 1.0 / ratio, "how far the velocity moves the robot")]
    return []


def foreign_velocities(data: Dataset) -> list[ForeignUnit]:
    """The velocity, by how the position changes."""
    return _foreign(velocity_agreement(list(data)), "what the position changes by")


def foreign_rates(data: Dataset) -> list[ForeignUnit]:
    """The body rates, by how the attitude or heading turns."""
    return _foreign(rate_agreement(list(data)), "what the robot turns by")


def _foreign(found: Mapping[str, Agreement], than: str) -> list[ForeignUnit]:
    ratio = _ratio(found.values())
    return [] if ratio is None or ratio < LARGE else [named(tuple(found), ratio, than)]


def _ratio(found: Collection[Agreement]) -> float | None:
    """Logged over derived, where all that can be judged are as many times as large; None where nothing can be."""
    judged = [abs(one.ratio) for one in found if one.correlation is not None and abs(one.correlation) >= AGREES]
    if not judged or not all(judged):
        return None
    middle = exp(median(np.log(judged)))
    return middle if max(abs(np.log(judged) - log(middle))) < log(LARGE) else 1.0


def _plain(number: float) -> str:
    return np.format_float_positional(number, precision=3, fractional=False, trim="-")
