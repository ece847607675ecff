"""Columns in another unit than the vocabulary's, known by how many times too large or small they are: deg/s, mm.

What is measured twice tells: rates against the attitude that they turn, velocities against the position that they move,
and how a quadrotor is pushed aside against where its thrust points. A column is judged alone, and only where both
go together so well that noise cannot make one seem larger; those that hardly move go with the others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import log

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import Agreement, rate_agreement, thrust_agreement, velocity_agreement
from sym2real.diagnosis.data.changed import divided
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.sources import AsRead
from sym2real.logs.units import UNITS
from sym2real.vocabulary import POSITION

POSITIONS = POSITION.columns
Judged = tuple[Mapping[str, float | None], str]  # column → logged over meant, and over what


@dataclass(frozen=True)
class ForeignUnit:
    """Columns that are not in the unit that they stand for.

    Args:
        columns: of the state or the action.
        meant: their unit.
        ratio: what is logged over what is meant, as found.
        unit: key of :data:`~sym2real.logs.units.UNITS` that numbers too large are in, and that numbers too small are
            read as; "" where none has such a factor.
        factor: what is logged over what is meant, of that unit; as found where there is none.
        than: what they are so many times, for a sentence.
        mass: kg, of a thrust that is logged per unit mass.
        log: place and name of the one log in which they are; None where it is so in all.
    """

    columns: tuple[str, ...]
    meant: str
    ratio: float
    unit: str
    factor: float
    than: str
    mass: float | None = None
    log: tuple[int, str] | None = None

    @property
    def evidence(self) -> str:
        """What shows it, one clause."""
        names = " ".join(self.columns)
        named = f"{self.unit} instead of {self.meant}", f"{self.meant} that are read as {self.unit}"
        unit = named[self.factor < 1.0] if self.unit else f"no unit of {self.meant} that is known"
        where = "" if self.log is None else f" in {self.log[1]}, other than in other logs"
        return f"{names} in {unit}{where}: the logged numbers are {_plain(self.ratio)} times {self.than}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns of the log."""
        named = self.unit if self.factor > 1.0 else self.meant
        value = f'unit = "{named}"' if self.unit else read.scale(1.0 / self.factor)
        change = f"give {' and '.join(read.columns(self.columns))} {value} in a specification of the log"
        per_mass = self.unit and UNITS[named][0] == "m/s^2" and self.meant == "N"
        return f"{change}, and mass = {self.mass:g} at its top" if per_mass else change

    def undone(self, data: Dataset) -> Dataset:
        """The logs with these columns in the unit that is meant."""
        return divided(data, self.columns, self.factor, only=None if self.log is None else self.log[0])


def unit_of(
    meant: str, ratio: float, least: float, unheard_of: float = SETTINGS.unheard_of, mass: float | None = None
) -> tuple[str, float] | None:
    """Unit and factor of numbers that are so many times what is meant; "" and the ratio where it has no name.

    Args:
        meant: the unit that stands there.
        ratio: what is logged over what is meant.
        least: factor of a unit, or its inverse, below which nobody tells it from what a robot does.
        unheard_of: from which a ratio, or its inverse, is another unit even if it has no name.
        mass: kg, where a thrust may be logged per unit mass.

    Returns:
        None where the ratio is that of no unit, and not so far from 1 that there must be one.
    """
    sign = 1.0 if ratio > 1.0 else -1.0
    known = {unit: factor**sign for unit, factor in factors(meant, mass).items() if factor >= least}
    unit = min(known, key=lambda name: abs(log(known[name] / ratio)), default="")
    if unit and abs(log(known[unit] / ratio)) <= log(SETTINGS.unit_near):
        return unit, known[unit]
    return ("", ratio) if abs(log(ratio)) >= log(unheard_of) else None


def factors(meant: str, mass: float | None = None) -> dict[str, float]:
    """Unit → how many times larger its numbers are than those in the unit meant; ``mass`` as of :func:`unit_of`."""
    found = {unit: 1.0 / value for unit, (inside, value) in UNITS.items() if inside == meant}
    if meant == "N" and mass is not None:
        found |= {unit: 1.0 / (value * mass) for unit, (inside, value) in UNITS.items() if inside == "m/s^2"}
    return found


def foreign_positions(data: Dataset) -> list[ForeignUnit]:
    """Position and joints, by a quadrotor's pushes or by the rates that they should have."""
    return _by_log(_positions, data)


def foreign_velocities(data: Dataset) -> list[ForeignUnit]:
    """The velocity, by how the position changes."""
    return _by_log(
        lambda logs: (_ratios(velocity_agreement(list(logs))), "what the position or joint changes by"), data
    )


def foreign_rates(data: Dataset) -> list[ForeignUnit]:
    """The body rates, by how the attitude or heading turns."""
    return _by_log(lambda logs: (_ratios(rate_agreement(list(logs))), "what the robot turns by"), data)


def _positions(data: Dataset) -> Judged:
    pushed = _ratio(thrust_agreement(list(data)))
    if pushed is not None and abs(log(pushed)) >= log(SETTINGS.unheard_of):  # nearer, thrust is of a fast turn
        columns = (name for name in POSITIONS if name in data.layouts.state)
        return dict.fromkeys(columns, pushed), "how far thrust moves the robot"
    moved, rates = _ratios(velocity_agreement(list(data))), data.layouts.state.rates.items()
    inverse = {place: None if (ratio := moved[rate]) is None else 1.0 / ratio for place, rate in rates}
    level = [ratio for place in POSITIONS[:2] if (ratio := inverse.get(place)) is not None]
    small = [ratio for ratio in level if pushed is not None and abs(log(ratio / pushed)) > abs(log(pushed))]
    for place, ratio in inverse.items():
        # Of a coordinate and its rate the larger numbers are wrong, but where thrust says that the smaller are.
        if ratio and (ratio < 1.0 or any(abs(log(ratio / other)) < log(SETTINGS.unit_near) for other in small)):
            inverse[place] = 1.0
    return inverse, "how far its rate moves it"


def _ratios(found: Mapping[str, Agreement]) -> dict[str, float | None]:
    return {name: _ratio(agreement) for name, agreement in found.items()}


def _by_log(judge: Callable[[Dataset], Judged], data: Dataset) -> list[ForeignUnit]:
    """What is so in all logs, or, where logs that can be judged contradict each other, what is so in each."""
    meant = data.layouts.state.units
    alone = [judge(Dataset([log])) for log in data] if len(data) > 1 else []
    judged = [{name: ratio for name, ratio in ratios.items() if ratio is not None} for ratios, _ in alone]
    large = [{name for name, ratio in own.items() if unit_of(meant[name], ratio, SETTINGS.far)} for own in judged]
    if any(set[str]().union(*large) & own.keys() - here for own, here in zip(judged, large, strict=True)):
        return [
            in_one_log(foreign, data, place) for place, own in enumerate(alone) for foreign in _foreign(*own, meant)
        ]
    return _foreign(*judge(data), meant)


def in_one_log(foreign: ForeignUnit, data: Dataset, place: int) -> ForeignUnit:
    """As found in the log at this place alone."""
    return replace(foreign, log=(place, data[place].name))


def _foreign(ratios: Mapping[str, float | None], than: str, meant: Mapping[str, str]) -> list[ForeignUnit]:
    """One entry for each unit that columns are in; what cannot be judged is in the one that all others are in."""
    judged = {name: ratio for name, ratio in ratios.items() if ratio is not None}
    units = {name: (meant[name], unit_of(meant[name], ratio, SETTINGS.far)) for name, ratio in judged.items()}
    entries = []
    for wanted, found in sorted({(wanted, found[0]) for wanted, found in units.values() if found is not None}):
        own = [name for name, (unit, known) in units.items() if unit == wanted and known and known[0] == found]
        alike = [name for name in ratios if meant[name] == wanted]
        columns = tuple(alike) if all(name in own or ratios[name] is None for name in alike) else tuple(own)
        ratio = float(np.exp(np.mean(np.log([judged[name] for name in own]))))
        factor = factors(wanted)[found] ** np.sign(log(ratio)) if found else ratio
        entries.append(ForeignUnit(columns, wanted, ratio, found, float(factor), than))
    return entries


def _ratio(agreement: Agreement) -> float | None:
    """How many times as large as the derivative a column is; None where nobody can tell, or in another frame."""
    if agreement.correlation is None or abs(agreement.correlation) < SETTINGS.nearly or not agreement.ratio:
        return None
    elsewhere = agreement.in_other_frame
    return None if elsewhere is not None and elsewhere > agreement.correlation else agreement.ratio


def _plain(number: float) -> str:
    return np.format_float_positional(number, precision=3, fractional=False, trim="-")
