"""Commands in another unit than the model's: with them a model predicts worse by far than that nothing changes.

A thrust in mN, rates in deg/s, motors in percent or 16 bits: each is divided by every factor on a grid, and belongs to
a unit where one step ahead is then foretold. Nothing less than absurd predictions counts: a gain is an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import exp, log

import numpy as np
import torch
from scipy.optimize import minimize_scalar

from sym2real.diagnosis.foreign_units import LARGE, ForeignUnit, factors
from sym2real.diagnosis.inputs import with_inputs
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

# Mean squares, of those by which the state changes in a step: what predictions must miss as the commands stand, and
# how many times less in the right unit.
ABSURD, BETTER = 10.0, 10.0
AS_GOOD = 2.0  # times the least: a unit that is known is as good as the best factor
GRID = np.geomspace(LARGE, 1e6, 90)
MOST_ROWS = 500


def foreign_commands(model: Equations, data: Dataset) -> list[ForeignUnit]:
    """Commands that stand in another unit; those of one unit together where all of them do."""
    known = with_inputs(model.layouts.inputs, data)
    if replace(model.layouts, state=visible_state(model)) != known.layouts:
        return []
    steps, found = _Steps(VisibleModel(model, torch.float64), known), list[ForeignUnit]()
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
        least = min(steps.missed(columns, factor) for factor in GRID)
        if least < best[0]:
            best = least, _unit(steps, columns, mass)
    return best[1]


def _unit(steps: _Steps, columns: tuple[str, ...], mass: float | None) -> ForeignUnit:
    """The known unit that is as good as the best factor; else the factor alone."""
    place = int(np.argmin([steps.missed(columns, factor) for factor in GRID]))
    low, high = GRID[max(0, place - 1)], GRID[min(len(GRID), place + 2) - 1]
    found = minimize_scalar(lambda at: steps.missed(columns, exp(at)), bounds=(log(low), log(high)), method="bounded")
    known = factors(columns[0], mass)
    missed = {unit: steps.missed(columns, factor) for unit, factor in known.items()}
    unit = min(missed, key=lambda one: missed[one], default="")
    ratio, than = exp(found.x), "what moves the robot as the model says"
    if unit and missed[unit] <= AS_GOOD * found.fun:
        return ForeignUnit(columns, ratio, unit, known[unit], than)
    return ForeignUnit(columns, ratio, "", ratio, than)


class _Steps:
    """Rows of logs one step apart, and what a model makes of them with commands divided by something."""

    def __init__(self, predict: VisibleModel, data: Dataset) -> None:
        self._predict, self._state, self._action = predict, data.layouts.state, data.layouts.action
        lengths = [len(one) for one in data]
        firsts = np.cumsum([0, *lengths[:-1]])
        rows = np.concatenate([np.arange(n - 1) + first for n, first in zip(lengths, firsts, strict=True)])
        rows = rows[:: max(1, len(rows) // MOST_ROWS)]
        state, self._sent, inputs = (
            torch.as_tensor(np.concatenate([getattr(one, name) for one in data]))
            for name in ("state", "action", "inputs")
        )
        self._now, self._later, self._sent = state[rows], state[rows + 1], self._sent[rows]
        self._given = inputs[rows] if inputs.shape[-1] else None
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
        self._sent[:, self._action.indices(columns)] /= factor

    def missed(self, columns: Sequence[str], factor: float) -> float:
        """Mean square of a step's error over that of the step itself, with columns divided by a factor."""
        sent = self._sent.clone()
        sent[:, self._action.indices(columns)] /= factor
        error = self._state.difference(self._later, self._predict(self._now, sent, self._given)).square().mean(0)
        moving = self._changed > 0
        missed = float((error[moving] / self._changed[moving]).mean())
        return missed if np.isfinite(missed) else float("inf")
