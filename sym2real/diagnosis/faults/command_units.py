"""Commands in another unit than the model's: with them a model predicts worse by far than that nothing changes.

A thrust in mN or as a part of 1, rates in deg/s, motors in percent or 16 bits: each is divided by every factor on a
grid, and belongs to the unit whose factor is nearest to the one by which a step ahead is foretold. A gain or a limit of
a few times is an effect; so units that are less than ten times apart are not told here.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, log

import numpy as np
import torch
from scipy.optimize import minimize_scalar

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.changed import divided
from sym2real.diagnosis.data.preparation import from_row_to_row
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, in_one_log, unit_of
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.filters import filter_commands
from sym2real.effects.visible import VisibleModel
from sym2real.symbolic import Equations

THAN = "what moves the robot as the model says"
FAR = 3.0  # times
GRID = np.geomspace(1e-5, 1e7, 120)
MOST_ROWS = 500


class Steps:
    """Rows of logs one step apart, and what a model makes of them with commands divided by something."""

    def __init__(self, model: Equations, predict: VisibleModel, data: Dataset) -> None:
        self.model, self._predict, self.data = model, predict, data
        self._state, self._action = data.layouts.state, data.layouts.action
        lengths = [len(log) for log in data]
        firsts = np.cumsum([0, *lengths[:-1]])
        rows = np.concatenate([np.arange(n - 1) + first for n, first in zip(lengths, firsts, strict=True)])
        self._rows = rows[:: max(1, len(rows) // MOST_ROWS)]
        state, inputs = (
            torch.as_tensor(np.concatenate([getattr(log, k) for log in data])) for k in ("state", "inputs")
        )
        self._now, self._later = state[self._rows], state[self._rows + 1]
        self._given = inputs[self._rows] if inputs.shape[-1] else None
        self._changed = self._state.difference(self._later, self._now).square().mean(0)

    @classmethod
    def of(cls, model: Equations, data: Dataset) -> Steps | None:
        """None where the logs have other columns than the model, or nothing moves."""
        found = from_row_to_row(model, data)
        steps = None if found is None else cls(model, *found)
        return None if steps is None or not bool((steps._changed > 0).any()) else steps

    def only(self, place: int) -> Steps:
        """Those of the log at this place."""
        return Steps(self.model, self._predict, Dataset([self.data[place]]))

    def groups(self, settled: Sequence[str]) -> list[tuple[str, ...]]:
        """Columns that may share a unit: all that have one in common, and each by itself."""
        units, shared = self._action.units, dict[str, list[str]]()
        for name in self._action:
            if name not in settled:
                shared.setdefault(units[name], []).append(name)
        alone = [(name,) for columns in shared.values() if len(columns) > 1 for name in columns]
        return [*map(tuple, shared.values()), *alone]

    def scale(self, columns: Sequence[str], factor: float) -> None:
        """Divide columns from now on."""
        self.data = divided(self.data, columns, factor)

    def around(self, columns: Sequence[str]) -> tuple[float, float]:
        """The factors on the grid between which least is missed."""
        place = int(self.errors(columns, GRID).mean(-1).argmin())
        return float(GRID[max(0, place - 1)]), float(GRID[min(len(GRID) - 1, place + 1)])

    def best(self, columns: Sequence[str], between: tuple[float, float]) -> tuple[float, float]:
        """What is missed with the factor by which least is, and that factor."""
        bounds = log(between[0]), log(between[1])
        result = minimize_scalar(lambda at: self.missed(columns, exp(at)), bounds=bounds, method="bounded")
        return float(result.fun), exp(result.x)

    def rise(self, columns: Sequence[str], factor: float) -> float:
        """How many times more is missed, in the column where most is, with columns divided by far more and far less."""
        here, *beside = self.errors(columns, [factor * by for by in (1.0, FAR, 1.0 / FAR)])
        return float((torch.minimum(*beside) / here).max())

    def missed(self, columns: Sequence[str], factor: float) -> float:
        """Mean of :meth:`errors`."""
        return float(self.errors(columns, [factor]).mean())

    def errors(self, columns: Sequence[str], factors: Sequence[float] | np.ndarray) -> torch.Tensor:
        """Mean square of a step's error over that of the step itself, of every column that moves.

        Args:
            columns: commands that are divided.
            factors: what they are divided by ``# (F,)``.

        Returns:
            ``# (F, k)``, in one rollout of all factors; infinite where it is no number.
        """
        by = torch.ones(len(factors), 1, len(self._action), dtype=torch.float64)
        by[..., self._action.indices(columns)] = torch.as_tensor(factors, dtype=torch.float64)[:, None, None]
        logs = [filter_commands(self.model, torch.as_tensor(log.action) / by, dt=self.data.dt) for log in self.data]
        sent = torch.cat(logs, dim=1)[:, self._rows]
        given = None if self._given is None else self._given.expand(len(by), -1, -1)
        after = self._predict(self._now.expand(len(by), -1, -1), sent, given)
        error = self._state.difference(self._later.expand_as(after), after).square().mean(1)
        return (error / self._changed)[:, self._changed > 0].nan_to_num(nan=inf, posinf=inf)


def foreign_commands(model: Equations, data: Dataset) -> list[ForeignUnit]:
    """Commands that stand in another unit, in all logs, or in each where what mends all makes one worse."""
    together = Steps.of(model, data)
    if together is None:
        return []
    alone, found = [together.only(place) for place in range(len(data))], _foreign(together)
    pairs = ((own.missed((), 1.0), together.only(place).missed((), 1.0)) for place, own in enumerate(alone))
    if len(data) == 1 or (found and all(now <= SETTINGS.unit_near * before for before, now in pairs)):
        return found
    return [in_one_log(foreign, data, place) for place, own in enumerate(alone) for foreign in _foreign(own)]


def _foreign(steps: Steps) -> list[ForeignUnit]:
    """Those of one unit together where all of them are in another."""
    units = list[ForeignUnit]()
    for _ in steps.data.layouts.action:
        foreign = _most_foreign(steps, [name for each in units for name in each.columns])
        if foreign is None:
            break
        steps.scale(foreign.columns, foreign.factor)
        units.append(foreign)
    return units


def _most_foreign(steps: Steps, settled: Sequence[str]) -> ForeignUnit | None:
    """The columns whose other unit mends most of what is missed."""
    mass, (now,) = steps.model.numbers.get("mass"), steps.errors((), [1.0])
    if not (now > 1.0).any():
        return None
    best: tuple[float, ForeignUnit | None] = (inf, None)
    for columns in steps.groups(settled):
        between = steps.around(columns)
        if max(between[1], 1.0 / between[0]) < SETTINGS.command_unit / SETTINGS.unit_near:
            continue  # of no unit, wherever between these
        least, ratio = steps.best(columns, between)
        sure = least < best[0] and steps.rise(columns, ratio) > SETTINGS.command_sides
        meant = steps.data.layouts.action.units[columns[0]]
        found = unit_of(meant, ratio, SETTINGS.command_unit, SETTINGS.command_unit, mass) if sure else None
        if found is not None and _mended(now, steps.errors(columns, [ratio])[0]):
            best = least, ForeignUnit(columns, meant, ratio, *found, THAN, mass)
    return best[1]


def _mended(now: torch.Tensor, then: torch.Tensor) -> bool:
    """Whether a column that is missed by more than it changes is missed far less, and no other becomes one."""
    better, worse = now > SETTINGS.far * then, then > SETTINGS.unit_near * now
    return bool((better & (now > 1.0)).any() and not (worse & (then > 1.0)).any())
