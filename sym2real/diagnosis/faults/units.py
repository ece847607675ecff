"""Columns that are so many times what is meant: in another unit, of the model's mass, or measured before a gear."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import exp, log, log10

import numpy as np
from scipy.optimize import minimize_scalar

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import present
from sym2real.diagnosis.faults.mistakes.balance import Balance, Balances
from sym2real.diagnosis.faults.mistakes.transformation import of_all
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.sources import AsRead
from sym2real.logs.units import UNITS, standard_unit
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import POSITION, rate_column

STEP, LARGEST = 1.5, 1e5  # of the grid of factors, and of their inverses
ROWS_AT_ONCE = 20_000  # of logs under several factors, which a model predicts in one go
SENSED = SETTINGS.far, SETTINGS.unheard_of


@dataclass(frozen=True)
class Scaled:
    """Columns that are so many times what is meant.

    Args:
        columns: of state or action.
        factor: what is logged over what is meant.
        unit: key of :data:`~sym2real.logs.units.UNITS` that numbers too large are in, and that numbers too small are
            read as, of the first column; "" where none has this factor.
        mass: kg, of a thrust that is logged per unit mass.
    """

    columns: tuple[str, ...]
    factor: float
    unit: str = ""
    mass: float | None = None

    @property
    def _meant(self) -> str:
        return UNITS[self.unit][0] if self.mass is None else "N"

    @property
    def name(self) -> str:
        """Which columns, and what they are in."""
        names = " ".join(self.columns)
        if not self.unit:
            return f"{names} in no unit of that size, or before a gear, {self.factor:.4g} times what is meant"
        large = f"{self.unit} instead of {self._meant}"
        return f"{names} in {large if self.factor > 1.0 else f'{self._meant} that are read as {self.unit}'}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns of the log."""
        shared_unit = self.unit and len({standard_unit(name) for name in self.columns}) == 1
        unit = shared_unit and (self.unit if self.factor > 1.0 else self._meant)
        rates = [name for name in self.columns if unit and name in map(rate_column, self.columns)]
        values = {per: f'unit = "{unit}{per}"' if unit else read.scale(1.0 / self.factor) for per in ("", "/s")}
        kinds = {"": [name for name in self.columns if name not in rates], "/s": rates}
        entries = [f"{' and '.join(read.columns(own))} {values[per]}" for per, own in kinds.items() if own]
        change = f"give {', '.join(entries)} in a specification of the log"
        return f"{change}, and mass = {self.mass:g} at its top" if self.mass and self.factor > 1.0 else change

    def undone(self, log: Trajectory) -> Trajectory:
        """In the unit that is meant."""
        return log.with_columns({name: log.column(name) / self.factor for name in self.columns})


def factors(meant: str, mass: float | None = None) -> dict[str, float]:
    """Unit → how many times larger its numbers are than those in the unit meant.

    Args:
        meant: the unit that stands there.
        mass: kg, where a thrust may be logged per unit mass.
    """
    ratios = {unit: 1.0 / value for unit, (inside, value) in UNITS.items() if inside == meant}
    if meant == "N" and mass is not None:
        ratios |= {unit: 1.0 / (value * mass) for unit, (inside, value) in UNITS.items() if inside == "m/s^2"}
    return ratios


def in_unit(
    columns: tuple[str, ...], meant: str, ratio: float, from_on: tuple[float, float] = SENSED, mass: float | None = None
) -> Scaled | None:
    """Columns that are so many times what is meant; None where that is no unit, and not so far off that it must be one.

    Args:
        columns: in question.
        meant: their unit.
        ratio: what is logged over what is meant, as found.
        from_on: factor of a unit, or its inverse, below which nobody tells it from what a robot does; and from which a
            ratio, or its inverse, is another unit even if it has no name.
        mass: as of :func:`factors`.
    """
    sign = 1.0 if ratio > 1.0 else -1.0
    known = {unit: factor**sign for unit, factor in factors(meant, mass).items() if factor >= from_on[0]}
    unit = min(known, key=lambda name: abs(log(known[name] / ratio)), default="")
    if unit and abs(log(known[unit] / ratio)) <= log(SETTINGS.unit_near):
        return Scaled(columns, known[unit], unit, None if UNITS[unit][0] == meant else mass)
    return Scaled(columns, ratio) if abs(log(ratio)) >= log(from_on[1]) else None


def best_factor(missed: Callable[[float], float], between: tuple[float, float]) -> float:
    """The factor between two by which least is missed."""
    bounds = log(between[0]), log(between[1])
    return exp(minimize_scalar(lambda at: missed(exp(at)), bounds=bounds, method="bounded").x)


def fitting_scales(balances: Balances, data: Dataset, now: Balance) -> Iterator[Scaled]:
    """For what the model predicts badly, joints and commands or the position, the factor that fits best."""
    state, action = data.layouts.state, data.layouts.action
    losses = dict(zip(now.names, now.losses.mean(0), strict=True))
    if losses.get("level velocity", 0.0) > SETTINGS.mostly:
        position = present(data, POSITION.columns)
        yield _best(balances, data, now, (*position, *(state.rates[place] for place in position)), "m")
    bad = [joint for joint in state.joints if losses[state.rates[joint]] > SETTINGS.mostly]
    if not bad:
        return
    units = state.units | action.units
    every = [[joint for joint in bad if units[joint] == unit] for unit in dict.fromkeys(units[joint] for joint in bad)]
    groups = [*([joint] for joint in bad), *(joints for joints in every if len(joints) > 1)]
    pairs = [(*joints, *(state.rates[joint] for joint in joints)) for joints in groups]
    for columns in (*pairs, *((command,) for command in action)):
        best = _best(balances, data, now, columns, units[columns[0]])
        if best.unit or len(columns) <= len(pairs[0]):  # several joints share a unit, and no gear
            yield best


def _best(balances: Balances, data: Dataset, now: Balance, columns: tuple[str, ...], meant: str) -> Scaled:
    def missed(*scales: float) -> list[float]:
        versions = Dataset(log for factor in scales for log in of_all(Scaled(columns, factor), data))
        return [float(part.losses.mean()) for part in balances(versions).parts(len(scales))]

    large = np.geomspace(SETTINGS.command_unit, LARGEST, round(log(LARGEST / SETTINGS.command_unit, STEP)))
    grid, at_once = (*large, *1.0 / large), max(1, ROWS_AT_ONCE // data.rows)
    lost = [loss for first in range(0, len(grid), at_once) for loss in missed(*grid[first : first + at_once])]
    least, start = min(zip(lost, grid, strict=True), key=lambda entry: entry[0])
    if least >= now.losses.mean():  # nor would any factor near it mend anything
        return Scaled(columns, start)
    factor = best_factor(lambda at: missed(at)[0], (start / STEP, start * STEP))
    sign = 1.0 if factor > 1.0 else -1.0
    named = {unit: value**sign for unit, value in factors(meant).items() if value >= SETTINGS.command_unit}
    unit = min(named, key=lambda unit: missed(named[unit]), default="")
    known = {named[unit]: unit} if unit else {}
    known.setdefault(10.0 ** round(log10(factor)), "")
    alike = [value for value in known if missed(value)[0] * SETTINGS.nearly < missed(factor)[0]]
    return Scaled(columns, *((alike[0], known[alike[0]]) if alike else (factor, "")))
