"""Which effects compete, which of their parameters move together, and where fits of them start."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import lru_cache

import numpy as np
import torch

from sym2real.diagnosis.predict.competitors import competing
from sym2real.diagnosis.predict.library import SWINGING, Library
from sym2real.effects import Effect, applicable, effect
from sym2real.effects.catalogue import require_patterns
from sym2real.effects.filters import spelled_out
from sym2real.effects.groups import Group, holding, others_of
from sym2real.effects.inputs import ANGLE
from sym2real.effects.manoeuvres import one_circle
from sym2real.effects.voltage import voltage_at_start, with_voltage
from sym2real.symbolic import Equations, compile_function
from sym2real.symbolic.expressions import names_in
from sym2real.trajectory import Array, Dataset, Trajectory

PAIR = ("wx_cmd", "wy_cmd")
GRIDS: dict[str, tuple[float, ...]] = {
    "delay": (1.0, 2.0, 4.0),
    "lag": (2.5,),
    "motor_lag": (1.5, 3.0),
    "tyre_friction": (0.25, 0.4, 0.6),
    "dead_band": (0.5, 1.0),
    "rate_limit": (1.0, 3.0),
}
LIMIT_QUANTILES, LIMIT_PARTS = (0.5, 0.75, 0.9), (0.4, 0.6, 0.8)
# Part of its largest value to one side that a command reaches to the other where its limits count as alike.
BOTH_WAYS = 0.5


@dataclass(frozen=True)
class Candidate:
    """A hypothesis that competes.

    Args:
        name: key of its effect; of the first of several that move together.
        keys: its effects.
        free: slots, those that move together in one tuple.
        starts: further starting values of the first free parameter; the null value is always one.
        needs_start: the null value is no start, because nothing changes there.
        alike: keys of effects that this data cannot tell from it, by physics.
        excludes: those of them that cannot be found beside it.
    """

    name: str
    keys: tuple[str, ...]
    free: tuple[tuple[int, ...], ...]
    starts: tuple[float, ...] = ()
    needs_start: bool = False
    alike: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()

    @property
    def slots(self) -> list[int]:
        """All free slots, those that move together too."""
        return [slot for tied in self.free for slot in tied]


def library_for(
    equations: Equations, data: Dataset, exclude: Collection[str] = (), include: Sequence[str] = ()
) -> Library:
    """The equations with every effect that is to be tried on this data, and those to be included in any case.

    Logs with the battery's voltage give the equations that input, so that thrust may sag with it.
    """
    require_patterns(exclude)
    equations = with_inputs_of(equations, data)
    return _library(equations, tuple(dict.fromkeys((*competing(equations, data, exclude)[0], *include))))


def with_inputs_of(equations: Equations, data: Dataset) -> Equations:
    """The equations with the battery's voltage as an input where the logs have it, so that thrust may sag with it."""
    reference = voltage_at_start(data)
    if reference is None or "thrust" not in (*equations.layouts.action, *equations.quantities):
        return equations
    return with_voltage(equations, reference)


@lru_cache(maxsize=4)
def _library(equations: Equations, keys: tuple[str, ...]) -> Library:
    """Kept, because composing and compiling takes longer than a search in which many logs are diagnosed."""
    return Library.of(equations, [effect(key, equations) for key in keys])


def candidates(library: Library, data: Dataset) -> tuple[Candidate, ...]:
    """What competes: one candidate per effect; the two lateral rate commands as one."""
    found: list[Candidate] = []
    groups, known = holding(data), [one.key for one in applicable(library.equations)]
    exclusive = [group for group in groups if group.one_of]
    for key, one in library.effects.items():
        slots = library.indices(key)
        if not slots or one.column == PAIR[1] or (one.kind in SWINGING and not swings(data)):
            continue
        keys: tuple[str, ...] = (key,)
        free: tuple[tuple[int, ...], ...] = tuple((slot,) for slot in slots)
        if one.column == PAIR[0]:
            twin = f"{one.kind}:{PAIR[1]}"
            if twin in library.effects:
                keys, other = (key, twin), library.indices(twin)
                free = (
                    tuple(zip(slots, other, strict=True)) if one.kind != "offset" else (*free, *((s,) for s in other))
                )
        if one.kind == "wind":  # a vertical force is thrust's: mass, its map, its offset
            free = tuple(f for f in free if library.slots[f[0]].parameter.name != "fz")
        if one.kind == "lever_arm" and one_circle(data):  # an arm aside is the speed's: its gain, its limit
            free = tuple(f for f in free if library.slots[f[0]].parameter.name != "ry")
        if one.kind == "limit":
            end = "magnitude" if _turns_both_ways(one, data) else "upper"
            free = tuple(f for f in free if library.slots[f[0]].parameter.name == end)
        starts, needs = _starts(library, one, data)
        alike, excludes = _matching(key, groups, known), _matching(key, exclusive, known)
        found.append(Candidate(key, keys, free, starts, needs, alike, excludes))
    return tuple(found)


def swings(data: Dataset) -> bool:
    """Whether a swing has been found in the logs."""
    return any(ANGLE in log.extra for log in data)


def _matching(key: str, groups: Iterable[Group], known: Iterable[str]) -> tuple[str, ...]:
    patterns = others_of(key, groups)
    return tuple(one for one in known if one != key and any(fnmatch(one, pattern) for pattern in patterns))


def _starts(library: Library, one: Effect, data: Dataset) -> tuple[tuple[float, ...], bool]:
    dt = library.equations.dt
    if one.kind in ("delay", "lag", "motor_lag"):
        return tuple(dt * step for step in GRIDS[one.kind]), False
    if one.kind == "tyre_friction":
        return GRIDS["tyre_friction"], True
    if one.kind in ("limit", "rate_limit", "dead_band"):
        values = np.concatenate([column_values(library.equations, one.column, trajectory) for trajectory in data])
        if one.kind == "limit":
            return _levels(values, _turns_both_ways(one, data)), True
        spread = float(np.std(values))
        unit = spread / dt * 0.2 if one.kind == "rate_limit" else spread * 0.5
        return tuple(unit * step for step in GRIDS[one.kind]), True
    return (), False


def _levels(values: Array, both_ways: bool) -> tuple[float, ...]:
    """Where a limit may lie. A command that turns is often at its own ends, and no quantile lies between them."""
    if both_ways:
        return tuple(float(np.abs(values).max()) * part for part in LIMIT_PARTS)
    return tuple(np.quantile(values[values > 0], LIMIT_QUANTILES).tolist()) if (values > 0).any() else ()


def _turns_both_ways(one: Effect, data: Dataset) -> bool:
    """Whether a command is an angle to both sides, whose travel ends alike; a motor does not stop alike backwards."""
    if one.body.unit != "rad":
        return False
    reached = [max((side * log.column(one.column)).max() for log in data) for side in (1.0, -1.0)]
    return bool(min(reached) > BOTH_WAYS * max(reached))


def column_values(equations: Equations, name: str, trajectory: Trajectory) -> Array:
    """A column of a log, or a quantity that the equations derive from its columns ``# (rows,)``."""
    if name not in equations.quantities:
        return trajectory.column(name)
    expression = spelled_out(equations, equations.quantities[name])
    columns = sorted(names_in(expression))
    rows = torch.as_tensor(np.stack([trajectory.column(column) for column in columns], axis=1))
    derived: Array = compile_function([expression], [columns])(rows)[:, 0].numpy()
    return derived
