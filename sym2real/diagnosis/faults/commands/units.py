"""Commands in another unit than the model's: with them a model predicts worse by far than that nothing changes.

A thrust in mN, rates in deg/s, motors in percent or 16 bits: each is divided by every factor on a grid, and belongs to
the unit whose factor is nearest to the one by which a step ahead is foretold. A gain or a limit of a few times is an
effect; so units that are less than ten times apart are not told here.
"""

from __future__ import annotations

from collections.abc import Sequence

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.commands.steps import Steps
from sym2real.diagnosis.faults.foreign_units import ForeignUnit, in_one_log, unit_of
from sym2real.diagnosis.settings import SETTINGS
from sym2real.symbolic import Equations

THAN = "what moves the robot as the model says"


def foreign_commands(model: Equations, data: Dataset) -> list[ForeignUnit]:
    """Commands that stand in another unit, in all logs, or in each where they contradict each other."""
    together = Steps.of(model, data)
    if together is None or not together.missed((), 1.0) > SETTINGS.command_unit:
        return []
    alone = [_foreign(together.only(place)) for place in range(len(data))] if len(data) > 1 else []
    columns = {frozenset(name for foreign in own for name in foreign.columns) for own in alone}
    units = {(foreign.columns, foreign.unit) for own in alone for foreign in own if foreign.unit}
    if len(columns) > 1 or len({known for known, _ in units}) < len(units):
        return [in_one_log(foreign, data, place) for place, own in enumerate(alone) for foreign in own]
    return _foreign(together)


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
    mass = steps.model.numbers.get("mass")
    as_it_stands = steps.missed((), 1.0)
    if not as_it_stands > SETTINGS.command_unit:
        return None
    best: tuple[float, ForeignUnit | None] = (as_it_stands / SETTINGS.command_unit, None)
    for columns in steps.groups(settled):
        least, ratio = steps.best(columns)
        sure = least < best[0] and steps.rise(columns, ratio) > SETTINGS.command_sides
        meant = steps.data.layouts.action.units[columns[0]]
        found = unit_of(meant, ratio, SETTINGS.command_unit, mass) if sure else None
        if found is not None:
            best = least, ForeignUnit(columns, meant, ratio, *found, THAN, mass)
    return best[1]
