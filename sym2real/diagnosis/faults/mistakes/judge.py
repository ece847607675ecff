"""Whether logs agree better with themselves and with a model, beyond chance, once a transformation is undone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import wilcoxon

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.balance import Balance, Balances, without_arm, without_drag
from sym2real.diagnosis.faults.mistakes.listed import mimics, transformations
from sym2real.diagnosis.faults.mistakes.transformation import (
    POSITIONS,
    Exchanged,
    Late,
    Transformation,
    Turned,
    of_all,
    present,
)
from sym2real.diagnosis.settings import SETTINGS
from sym2real.symbolic import Equations
from sym2real.trajectory import Array

MOST = 3  # mistakes in one set of logs
ROUNDING = 1e-6  # of the squares


@dataclass(frozen=True)
class Undoing:
    """A transformation that logs ask for, and what undoing it does to the balance.

    Args:
        transformation: what was done.
        quantity: in which it shows most surely.
        before, after: squares missed there over those of its change, as it stands and undone.
        gain: by how much the sum of these over all quantities falls.
    """

    transformation: Transformation
    quantity: str
    before: float
    after: float
    gain: float

    @property
    def evidence(self) -> str:
        """What is wrong: what shows it."""
        return (
            f"{self.transformation.name}: as it stands the logs miss {self.before:.2g} of the squares by which the "
            f"{self.quantity} changes, {self.after:.2g} without"
        )

    @property
    def fix(self) -> str:
        """What to change."""
        return self.transformation.fix

    def undone(self, data: Dataset) -> Dataset:
        """The logs as they are meant."""
        return of_all(self.transformation, data)


def mistakes(model: Equations, data: Dataset) -> list[Undoing]:
    """The transformations that the logs ask for, one after the other; on a line nothing can be turned or exchanged."""
    balances = Balances.of(model, data) if len(present(data, POSITIONS)) != 1 else None
    if balances is None:
        return []
    undoings = []
    for _ in range(MOST):
        undoing = _best(balances, data)
        # One sensor or command with the other sign is named as such, by an effect of its own.
        if undoing is None or (
            isinstance(undoing.transformation, Exchanged) and len(undoing.transformation.wrong) == 1
        ):
            break
        undoings.append(undoing)
        data = undoing.undone(data)
    return undoings


def _best(balances: Balances, data: Dataset) -> Undoing | None:
    """The transformation that gains most; of two kinds that gain as much the simpler."""
    now = balances(data)
    tried = list(transformations(data, now))
    kinds: dict[type, Undoing] = {}
    for transformation in tried:
        held = _judged(balances, now, transformation, data, len(tried))
        if held is not None and (type(transformation) not in kinds or held.gain > kinds[type(transformation)].gain):
            kinds[type(transformation)] = held
    most = max((undoing.gain for undoing in kinds.values()), default=0.0)
    return next((undoing for undoing in kinds.values() if undoing.gain >= SETTINGS.nearly_as_good * most), None)


def _judged(
    balances: Balances, now: Balance, transformation: Transformation, data: Dataset, tried: int
) -> Undoing | None:
    """What undoing it gains, where that is beyond chance and nothing else becomes worse."""
    before = now.losses
    after = balances(of_all(transformation, data)).losses
    old, new = before.mean(0), after.mean(0)
    better = old - new
    clear = (old > SETTINGS.mistake_fewer * new) & (new < SETTINGS.mistake_left)
    if not clear.any() or -better.min() > SETTINGS.others_worse * better.max() or _in_all(new) > _in_all(old):
        return None
    if isinstance(transformation, Turned) and transformation.field == "attitude":
        clear &= without_drag(now) > SETTINGS.mistake_fewer * new
    if isinstance(transformation, Late | Turned):
        clear &= without_arm(now) > SETTINGS.mistake_fewer * new
    for other in mimics(transformation, data.layouts.action.columns):
        mimicked = balances(of_all(other, data)).losses.mean(0)
        clear &= (mimicked > SETTINGS.mistake_fewer * new) & (_in_all(mimicked) > _in_all(new))
    chance = [
        _chance(before[:, place], after[:, place], now.block) if clear[place] else 1.0 for place in range(len(old))
    ]
    most = int(np.argmin(chance))
    if chance[most] > SETTINGS.false_alarms / tried:
        return None
    return Undoing(transformation, now.names[most], float(old[most]), float(new[most]), float(better.sum()))


def _in_all(losses: Array) -> float:
    """How badly all quantities ``# (q,)`` are foretold: minus their log-likelihood, each of a variance of its own."""
    return float(np.log(np.maximum(losses, ROUNDING)).sum())


def _chance(before: Array, after: Array, block: Array) -> float:
    """How likely blocks of a second would miss so many fewer squares by chance (Wilcoxon's signed ranks, 1945)."""
    _, places = np.unique(block, return_inverse=True)
    return float(wilcoxon(np.bincount(places, before - after), alternative="greater", zero_method="zsplit").pvalue)
