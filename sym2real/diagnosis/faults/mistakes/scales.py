"""Joints, commands and positions with their velocities that are so many times what is meant, as degrees are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.changed import with_columns
from sym2real.diagnosis.faults.foreign_units import factors
from sym2real.diagnosis.faults.mistakes.balance import Balance, Balances
from sym2real.diagnosis.faults.mistakes.transformation import POSITIONS, of_all, present
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.sources import AsRead
from sym2real.logs.units import UNITS
from sym2real.trajectory import Trajectory

STEP, LARGEST = 1.5, 1e5  # of factors that are tried, and of their inverses


@dataclass(frozen=True)
class Scaled:
    """Columns that are so many times what is meant: in another unit, or measured before a gear.

    Args:
        columns: a joint's coordinate and rate, those of several joints or of the position, or a command.
        factor: what is logged over what is meant.
        unit: of the first column; "" where none has this factor.
    """

    columns: tuple[str, ...]
    factor: float
    unit: str = ""

    @property
    def name(self) -> str:
        """Which columns, and how many times what is meant they are."""
        what = f"in {self.unit} instead of {UNITS[self.unit][0]}" if self.unit else "in another unit, or before a gear"
        return f"{' '.join(self.columns)} {what}, {self.factor:.4g} times what is meant"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns of the log."""
        own = " and ".join(read.columns(self.columns))
        return f"give {own} the unit, or {read.scale(1.0 / self.factor)}, in a specification of the log"

    def undone(self, log: Trajectory) -> Trajectory:
        """As meant."""
        return with_columns(log, {name: log.column(name) / self.factor for name in self.columns})


def fitting_scales(balances: Balances, data: Dataset, now: Balance) -> Iterator[Scaled]:
    """For what the model foretells badly, joints and commands or the position, the factor that fits best."""
    state, action = data.layouts.state, data.layouts.action
    losses = dict(zip(now.names, now.losses.mean(0), strict=True))
    if losses.get("level velocity", 0.0) > SETTINGS.mostly:
        position = present(data, POSITIONS)
        yield _best(balances, data, (*position, *(state.rates[place] for place in position)), "m")
    bad = [joint for joint in state.joints if losses[state.rates[joint]] > SETTINGS.mostly]
    if not bad:
        return
    units = state.units | action.units
    every = [[joint for joint in bad if units[joint] == unit] for unit in {units[joint] for joint in bad}]
    groups = [[joint] for joint in bad] + [joints for joints in every if len(joints) > 1]
    pairs = [(*joints, *(state.rates[joint] for joint in joints)) for joints in groups]
    for columns in (*pairs, *((command,) for command in action)):
        yield _best(balances, data, columns, units[columns[0]])


def _best(balances: Balances, data: Dataset, columns: Sequence[str], meant: str) -> Scaled:
    def missed(factor: float) -> float:
        loss: float = balances(of_all(Scaled(tuple(columns), factor), data)).losses.mean()
        return loss

    large = np.geomspace(SETTINGS.command_unit, LARGEST, round(math.log(LARGEST / SETTINGS.command_unit, STEP)))
    start = min((*large, *1.0 / large), key=missed)
    around = math.log(start / STEP), math.log(start * STEP)
    factor = math.exp(minimize_scalar(lambda at: missed(math.exp(at)), bounds=around, method="bounded").x)
    named = {unit: value for unit, value in factors(meant).items() if value >= SETTINGS.command_unit}
    unit = min(named, key=lambda unit: missed(named[unit]), default="")
    known = {named[unit]: unit} if unit else {}
    known.setdefault(10.0 ** round(math.log10(factor)), "")
    alike = [value for value in known if missed(value) * SETTINGS.nearly < missed(factor)]
    return Scaled(tuple(columns), *((alike[0], known[alike[0]]) if alike else (factor, "")))
