"""Commands in another unit than the model's: with them a model predicts worse by far than that nothing changes.

A thrust in mN, rates in deg/s, motors in percent or 16 bits: each is divided by every factor on a grid, and belongs to
the unit whose factor is nearest to the one by which a step ahead is foretold. A gain or a limit of a few times is an
effect; so units that are less than ten times apart are not told here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import exp, log

import numpy as np
import torch
from scipy.optimize import minimize_scalar

from sym2real.diagnosis.foreign_units import ForeignUnit, unit_of
from sym2real.diagnosis.inputs import with_inputs
from sym2real.diagnosis.prepared import with_filtered_commands
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

# Errors of a step by those of holding the state, in mean squares, averaged over the columns: what predictions must miss
# as the commands stand, how many times less in the right unit, and how many times more, in some column, with a factor
# that is far from it to either side.
ABSURD, BETTER, WORSE = 10.0, 10.0, 2.0
FAR = 3.0  # times
LEAST = 10.0  # times: below, a gain or a limit says it
GRID = np.geomspace(1.0, 1e7, 140)
MOST_ROWS = 500
THAN = "what moves the robot as the model says"


def foreign_commands(model: Equations, data: Dataset) -> list[ForeignUnit]:
    """Commands that stand in another unit; those of one unit together where all of them do."""
    known = with_inputs(model.layouts.inputs, data)
    if replace(model.layouts, state=visible_state(model)) != known.layouts:
        return []
    steps, found = _Steps(model, known), list[ForeignUnit]()
    for _ in known.layouts.action:
        one = _most_foreign(steps, model.numbers.get("mass"), [name for each in found for name in each.columns])
        if one is None:
            break
        steps.scale(one.columns, one.factor)
        found.append(one)
    return found


def _most_foreign(steps: _Steps, mass: float | None, settled: Sequence[str]) -> ForeignUnit | None:
    """The columns whose other unit mends most of what is missed."""
    as_it_stands = steps.missed((), 1.0)
    if not as_it_stands > ABSURD:
        return None
    best: tuple[float, ForeignUnit | None] = (as_it_stands / BETTER, None)
    for columns in steps.groups(settled):
        least, ratio = steps.best(columns)
        sure = least < best[0] and steps.rise(columns, ratio) > WORSE
        found = unit_of(columns[0], ratio, LEAST, mass) if sure else None
        if found is not None:
            best = least, ForeignUnit(columns, ratio, *found, THAN, mass)
    return best[1]


class _Steps:
    """Rows of logs one step apart, and what a model makes of them with commands divided by something."""

    def __init__(self, model: Equations, data: Dataset) -> None:
        self._model, self._predict, self._data = model, VisibleModel(model, torch.float64), data
        self._state, self._action = data.layouts.state, data.layouts.action
        lengths = [len(one) for one in data]
        firsts = np.cumsum([0, *lengths[:-1]])
        rows = np.concatenate([np.arange(n - 1) + first for n, first in zip(lengths, firsts, strict=True)])
        self._rows = rows[:: max(1, len(rows) // MOST_ROWS)]
        state, inputs = (
            torch.as_tensor(np.concatenate([getattr(one, k) for one in data])) for k in ("state", "inputs")
        )
        self._now, self._later = state[self._rows], state[self._rows + 1]
        self._given = inputs[self._rows] if inputs.shape[-1] else None
        self._changed = self._state.difference(self._later, self._now).square().mean(0)

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
        self._data = self._scaled(columns, factor)

    def best(self, columns: Sequence[str]) -> tuple[float, float]:
        """What is missed with the factor by which least is, and that factor."""
        missed = [self.missed(columns, factor) for factor in GRID]
        place = int(np.argmin(missed))
        around = log(GRID[max(0, place - 1)]), log(GRID[min(len(GRID) - 1, place + 1)])
        found = minimize_scalar(lambda at: self.missed(columns, exp(at)), bounds=around, method="bounded")
        return float(found.fun), exp(found.x)

    def rise(self, columns: Sequence[str], factor: float) -> float:
        """How many times more is missed, in the column where most is, with columns divided by far more and far less."""
        here, *beside = (self._errors(columns, factor * by) for by in (1.0, FAR, 1.0 / FAR))
        return float((torch.minimum(*beside) / here).max())

    def missed(self, columns: Sequence[str], factor: float) -> float:
        """Mean square of a step's error over that of the step itself, with columns divided by a factor."""
        missed = float(self._errors(columns, factor).mean())
        return missed if np.isfinite(missed) else float("inf")

    def _errors(self, columns: Sequence[str], factor: float) -> torch.Tensor:
        data = with_filtered_commands(self._model, self._scaled(columns, factor))
        sent = torch.as_tensor(np.concatenate([one.action for one in data]))[self._rows]
        error = self._state.difference(self._later, self._predict(self._now, sent, self._given)).square().mean(0)
        return (error / self._changed)[self._changed > 0]

    def _scaled(self, columns: Sequence[str], factor: float) -> Dataset:
        if not columns:
            return self._data
        scaled = []
        for one in self._data:
            action = one.action.copy()
            action[:, self._action.indices(columns)] /= factor
            scaled.append(replace(one, action=action))
        return Dataset(scaled)
