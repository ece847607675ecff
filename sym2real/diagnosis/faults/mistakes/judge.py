"""Whether logs agree better with themselves and with a model, beyond chance, once a transformation is undone."""

from dataclasses import replace
from math import inf

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import present
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.mistakes.balance import SHIFTED, Balance, Balances, chance, without_arm, without_drag
from sym2real.diagnosis.faults.mistakes.late_pose import with_its_place
from sym2real.diagnosis.faults.mistakes.listed import mimics, transformations
from sym2real.diagnosis.faults.mistakes.lost_commands import step_likelihood
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Late, Transformation, Turned, of_all
from sym2real.diagnosis.faults.units import Scaled, fitting_scales
from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.agreement import DOWN, above_ground
from sym2real.symbolic import Equations
from sym2real.trajectory import Array
from sym2real.vocabulary import POSITION

MOST = 3  # mistakes in one set of logs
ROUNDING = 1e-6  # of the squares
Gain = tuple[float, Breach]  # by how much the squares missed fall over all quantities, and what is undone


@np.errstate(over="ignore", invalid="ignore")  # of a wrong unit predictions may run away; what is no number gains none
def mistakes(model: Equations, data: Dataset) -> list[Breach]:
    """The transformations that the logs ask for, one after the other; on a line nothing can be turned or exchanged.

    What all logs ask for comes first; then each that is still unlike most is asked by itself.
    """
    balances = Balances.of(model, data) if len(present(data, POSITION.columns)) != 1 else None
    if balances is None:
        return []
    breaches = list[Breach]()
    for _ in range(MOST):
        shared = _one_by_one(balances, data, MOST)
        for breach in shared:
            data = breach.undone(data)
        # Of one at a time: what it shares with all others may show in all of them then.
        alone = {place: _one_by_one(balances, Dataset([data[place]]), 1) for place in _unlike_most(balances, data)}
        odd = [breach.in_log(data, place) for place, own in alone.items() for breach in own]
        for breach in odd:
            data = breach.undone(data)
        breaches += [*shared, *odd]
        if not odd:
            break
    return breaches


def _unlike_most(balances: Balances, data: Dataset) -> list[int]:
    """Places of the logs that a model predicts far worse than most of them, and badly."""
    places = [place for place, log in enumerate(data) if len(log) > balances.stretch(data.dt)]
    if len(places) < SETTINGS.fewest_logs:
        return []
    losses = np.stack([balances(Dataset([data[place]])).losses.mean(0) for place in places])
    odd = ((losses > SETTINGS.mostly) & (losses > SETTINGS.far * np.median(losses, axis=0))).any(axis=1)
    return [place for place, alone in zip(places, odd, strict=True) if alone] if odd.mean() < SETTINGS.mostly else []


def _one_by_one(balances: Balances, data: Dataset, most: int) -> list[Breach]:
    breaches = list[Breach]()
    for _ in range(most):
        breach = _best(balances, data) or _late_commands(balances, data)
        wrong = breach.transformation.wrong if breach and isinstance(breach.transformation, Exchanged) else []
        # One sensor of the other sign is named as such, by an effect of its own.
        if breach is None or (len(wrong) == 1 and wrong[0][0] in data.layouts.state):
            break
        breaches.append(breach)
        data = breach.undone(data)
    return breaches


def _best(balances: Balances, data: Dataset) -> Breach | None:
    """The transformation that gains most; of two kinds that gain as much the simpler."""
    now, inside = balances(data), balances.inside(data)
    trials = [*transformations(data, now), *fitting_scales(balances, data, now)]
    judged = [_judged(balances, inside if isinstance(case, Late) else now, case, data, len(trials)) for case in trials]
    held = sorted((gain for gain in judged if gain is not None), key=lambda gain: gain[0])
    best = {type(breach.transformation): (gain, breach) for gain, breach in held}
    least = SETTINGS.nearly * max((gain for gain, _ in held), default=0.0)
    chosen = next((best[kind][1] for kind in map(type, trials) if kind in best and best[kind][0] >= least), None)
    if chosen is None:
        return None
    if isinstance(late := chosen.transformation, Late):
        chosen = replace(chosen, transformation=with_its_place(late, data, balances))
    others = (breach.transformation for gain, breach in held if gain >= least)
    return replace(chosen, others=tuple(other.name for other in others if _apart(other, chosen.transformation)))


def _late_commands(balances: Balances, data: Dataset) -> Breach | None:
    """Commands written a row or two late, where that leaves at most half of the product of a step's error variances.

    Commands that change from row to row tell rows apart step by step; over a stretch their changes sum to little. What
    takes effect later than it is sent must not say as much.
    """
    if data.dt < (1.0 - SETTINGS.same) * balances.model.dt:  # such rows are no steps of the model
        return None
    # By rows that commands may be written late by, or take effect after.
    lates = [Late("commands", data.layouts.action.columns, rows, data.dt) for rows in range(-SHIFTED, SHIFTED + 1)]
    likely = [step_likelihood(balances.model, of_all(late, data)) for late in lates]
    best = int(np.argmax(likely))
    beside = max(value for late, value in zip(lates, likely, strict=True) if late.rows <= 0)
    # At the end of what is looked at there need be no most likely one; not below, as it may be no number.
    if best == len(lates) - 1 or not np.exp(2.0 * (beside - likely[best]) / sum(map(len, data))) < SETTINGS.mostly:
        return None
    late = _those_late(balances.model, data, lates[best], likely[best])
    old, new = (balances(logs).losses.mean(0) for logs in (data, of_all(late, data)))
    most = int(np.argmax(old - new))
    shown = _evidence(balances(data).names[most], old[most], new[most])
    # A gyro that is read when the next command is out says that commands are late, and the heading that they are not.
    times = new / np.maximum(old, ROUNDING)
    return Breach(late, shown) if new[most] < SETTINGS.mostly and times.max() <= SETTINGS.gap else None


def _those_late(model: Equations, data: Dataset, late: Late, likelihood: float) -> Late:
    """Without the commands that are on time: beyond chance, errors are smaller where they stay."""
    while len(late.columns) > 1:
        fewer = [replace(late, columns=tuple(n for n in late.columns if n != name)) for name in late.columns]
        likely = [step_likelihood(model, of_all(subset, data)) for subset in fewer]
        best = int(np.argmax(likely))
        if likely[best] - likelihood < SETTINGS.sensor_deviations**2:
            break
        late, likelihood = fewer[best], likely[best]
    return late


def _evidence(quantity: str, before: float, after: float) -> str:
    """What shows a transformation: in which quantity how much less is missed."""
    missed = f"{100 * before:.3g} % of the squared changes of the {quantity}"
    return f"model and log differ by {missed} as it stands, by {100 * after:.2g} % without"


def _apart(first: Transformation, second: Transformation) -> bool:
    """Whether two of one kind are of other columns."""
    if isinstance(first, Exchanged) and isinstance(second, Exchanged):
        return not {own for own, _ in first.wrong} & {own for own, _ in second.wrong}
    return isinstance(first, Scaled) and isinstance(second, Scaled) and not {*first.columns} & {*second.columns}


def _judged(balances: Balances, now: Balance, transformation: Transformation, data: Dataset, tests: int) -> Gain | None:
    """What undoing it gains, where that is beyond chance and nothing else becomes worse."""
    then = (balances.inside if isinstance(transformation, Late) else balances)(of_all(transformation, data))
    old, new = now.losses.mean(0), then.losses.mean(0)
    better = old - new
    # A velocity behind a filter is none of an early position: what both have in common only speaks against.
    counted = np.array([not name.endswith("by velocity") for name in now.names])
    clear = (old > SETTINGS.far * new) & (new < SETTINGS.mostly) & counted
    if not clear.any() or -better.min() > SETTINGS.others_worse * better.max() or _in_all(new) > _in_all(old):
        return None
    # Beside the ground, which lifts what comes near, thrust seems to push down.
    if isinstance(transformation, Exchanged) and DOWN in transformation.wrong and above_ground([*data]):
        return None
    if isinstance(transformation, Turned) and transformation.field == "attitude":
        clear &= without_drag(now) > SETTINGS.far * new
    if isinstance(transformation, Late | Turned):
        clear &= without_arm(now) > SETTINGS.far * new
    for other in mimics(transformation, data.layouts.action.columns):
        mimicked = balances.inside(of_all(other, data)).losses.mean(0)
        clear &= (mimicked > SETTINGS.far * new) & (_in_all(mimicked) > _in_all(new))
    # It must mend a part of what it does.
    does = 1.0 - np.cos(transformation.angle) if isinstance(transformation, Turned) else 1.0
    least = SETTINGS.worth_saying * does if isinstance(transformation, Exchanged | Scaled | Turned) else 0.0
    chances = [chance(now.missed(place), then.missed(place)) for place in np.flatnonzero(clear).tolist()]
    most = int(np.where(clear, better, -inf).argmax())
    if not (clear[most] and better[most] > least and min(chances) <= SETTINGS.false_alarms_of_each(tests)):
        return None
    return float(better.sum()), Breach(transformation, _evidence(now.names[most], old[most], new[most]))


def _in_all(losses: Array) -> float:
    """How badly all quantities ``# (q,)`` are predicted: minus their log-likelihood, each of a variance of its own."""
    return float(np.log(np.maximum(losses, ROUNDING)).sum())
