"""Commands in another unit than the model's: with them a model predicts worse by far than that nothing changes.

A thrust in mN, rates in deg/s, motors in percent or 16 bits: each is divided by every factor on a grid, and belongs to
the unit whose factor is nearest to the one by which a step ahead is foretold. A gain or a limit of a few times is an
effect; so units that are less than ten times apart are not told here.
"""

from __future__ import annotations

from collections.abc import Sequence

from sym2real.diagnosis.faults.command_steps import Steps
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, in_one_log, unit_of
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset

# Errors of a step by those of holding the state, in mean squares, averaged over the columns: what predictions must miss
# as the commands stand, how many times less in the right unit, and how many times more, in some column, with a factor
# that is far from it to either side.
ABSURD, BETTER, WORSE = 10.0, 10.0, 2.0
LEAST = 10.0  # times: below, a gain or a limit says it
THAN = "what moves the robot as the model says"


def foreign_commands(model: Equations, data: Dataset) -> list[ForeignUnit]:
    """Commands that stand in another unit, in all logs, or in each where they contradict each other."""
    together = Steps.of(model, data)
    if together is None or not together.missed((), 1.0) > ABSURD:
        return []
    alone = [_foreign(together.only(place)) for place in range(len(data))] if len(data) > 1 else []
    columns = {frozenset(name for one in own for name in one.columns) for own in alone}
    units = {(one.columns, one.unit) for own in alone for one in own if one.unit}
    if len(columns) > 1 or len({known for known, _ in units}) < len(units):
        return [in_one_log(one, data, place) for place, own in enumerate(alone) for one in own]
    return _foreign(together)


def _foreign(steps: Steps) -> list[ForeignUnit]:
    """Those of one unit together where all of them are in another."""
    found = list[ForeignUnit]()
    for _ in steps.data.layouts.action:
        one = _most_foreign(steps, [name for each in found for name in each.columns])
        if one is None:
            break
        steps.scale(one.columns, one.factor)
        found.append(one)
    return found


def _most_foreign(steps: Steps, settled: Sequence[str]) -> ForeignUnit | None:
    """The columns whose other unit mends most of what is missed."""
    mass = steps.model.numbers.get("mass")
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
