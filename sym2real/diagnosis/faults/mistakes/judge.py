"""Whether logs agree better with themselves and with a model, beyond chance, once a transformation is undone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import wilcoxon

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
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Dataset

# Squares missed over those of the change: how many times fewer without the mistake, how many may be left, and how much
# more, of that, any other quantity may miss.
FEWER, LEFT, WORSE = 3.0, 0.5, 0.25
MOST = 3  # mistakes in one set of logs
ALIKE = 0.9  # of the largest gain; of such that gain as much the simplest is taken
FALSE_ALARMS = 0.002  # a data set


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
    found = []
    for _ in range(MOST):
        one = _best(balances, data)
        # One sensor or command with the other sign is named as such, by an effect of its own.
        if one is None or (isinstance(one.transformation, Exchanged) and len(one.transformation.wrong) == 1):
            break
        found.append(one)
        data = one.undone(data)
    return found


def _best(balances: Balances, data: Dataset) -> Undoing | None:
    """The transformation that gains most; of two kinds that gain as much the simpler."""
    now = balances(data)
    tried = list(transformations(data, now))
    kinds: dict[type, Undoing] = {}
    for one in tried:
        held = _judged(balances, now, one, data, len(tried))
        if held is not None and (type(one) not in kinds or held.gain > kinds[type(one)].gain):
            kinds[type(one)] = held
    most = max((one.gain for one in kinds.values()), default=0.0)
    return next((one for one in kinds.values() if one.gain >= ALIKE * most), None)


def _judged(balances: Balances, now: Balance, one: Transformation, data: Dataset, tried: int) -> Undoing | None:
    """What undoing it gains, where that is beyond chance and nothing else becomes worse."""
    before = now.losses
    after = balances(of_all(one, data)).losses
    old, new = before.mean(0), after.mean(0)
    better = old - new
    clear = (old > FEWER * new) & (new < LEFT)
    if not clear.any() or -better.min() > WORSE * better.max():
        return None
    if isinstance(one, Turned) and one.field == "attitude":
        clear &= without_drag(now) > FEWER * new
    if isinstance(one, Late | Turned):
        clear &= without_arm(now) > FEWER * new
    for other in mimics(one, data.layouts.action.columns):
        clear &= balances(of_all(other, data)).losses.mean(0) > FEWER * new
    chance = [
        _chance(before[:, place], after[:, place], now.block) if clear[place] else 1.0 for place in range(len(old))
    ]
    most = int(np.argmin(chance))
    if chance[most] > FALSE_ALARMS / tried:
        return None
    return Undoing(one, now.names[most], float(old[most]), float(new[most]), float(better.sum()))


def _chance(before: Array, after: Array, block: Array) -> float:
    """How likely blocks of a second would miss so many fewer squares by chance (Wilcoxon's signed ranks, 1945)."""
    _, places = np.unique(block, return_inverse=True)
    return float(wilcoxon(np.bincount(places, before - after), alternative="greater", zero_method="zsplit").pvalue)
