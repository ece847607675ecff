"""Which effects compete in a diagnosis, and why each of the others does not: what was not tested is not refuted."""

from collections.abc import Collection
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import lru_cache

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.predict.library import library_of
from sym2real.effects import Effect
from sym2real.effects.catalogue import known
from sym2real.effects.filters import spelled_out
from sym2real.effects.groups import unnamed
from sym2real.errors import ModelError
from sym2real.symbolic import Equations, compile_function
from sym2real.symbolic.expressions import names_in
from sym2real.trajectory import Array, Trajectory

EXCLUDED = "excluded on request"
# Commands are as sent, without noise: one that varies less shows nothing of its map.
STILL = 1e-9


@dataclass(frozen=True)
class NotTested:
    """An effect that took no part in a search, and why."""

    effect: str
    reason: str


def competing(
    equations: Equations, data: Dataset, exclude: Collection[str] = ()
) -> tuple[tuple[str, ...], tuple[NotTested, ...]]:
    """Keys of the effects of such a robot that compete on this data, and all others."""
    refused: dict[str, str] = {}
    while True:
        reasons = _reasons(equations, data, exclude, refused)
        keys = tuple(key for key, reason in reasons.items() if not reason)
        more = {key: why for key in keys if (why := _refused(equations, key))} if _refused(equations, *keys) else {}
        if not more:
            return keys, tuple(NotTested(key, reason) for key, reason in reasons.items() if reason)
        refused |= more


def _reasons(equations: Equations, data: Dataset, exclude: Collection[str], refused: dict[str, str]) -> dict[str, str]:
    """Why each effect does not compete, "" where it does."""
    effects = {effect.key: effect for effect in known(equations)}
    reasons = {key: refused.get(key) or _why_not(effect, equations, data, exclude) for key, effect in effects.items()}
    others = {key: effect.stood_for_by for key, effect in effects.items() if not reasons[key]}
    same = {key: other for key, other in others.items() if reasons.get(other) == ""}
    reasons |= {key: f"{other} stands for it: no log tells them apart" for key, other in same.items()}
    left = {key for key, reason in reasons.items() if not reason}
    behind = unnamed(left, data).items()
    return reasons | {key: f"{by} stands for it: in these logs {why}" for key, (by, why) in behind if key in left}


def _why_not(effect: Effect, equations: Equations, data: Dataset, exclude: Collection[str]) -> str:
    """Why an effect does not compete; "" where it does."""
    if any(fnmatch(effect.key, pattern) for pattern in exclude):
        return EXCLUDED
    refused = effect.searching.why_not(effect.body) or effect.why_not(equations).removeprefix(f"{effect.key} ")
    return refused or still(equations, effect, data)


@lru_cache(maxsize=512)
def _refused(equations: Equations, *keys: str) -> str:
    """Why the equations cannot be given effects that have all they name: a force without a place, a number for that.

    "" where they can be; what comes of it is kept for the search.
    """
    try:
        library_of(equations, keys)
    except ModelError as error:
        return str(error)
    return ""


def values_for(equations: Equations, effect: Effect, data: Dataset) -> Array:
    """Values of the command that an effect is on, or of all, in all logs ``# (values,)``; none for other effects."""
    if effect.of.columns != "action":
        return np.zeros(0)
    pairs = ((name, trajectory) for trajectory in data for name in effect.body.bound)
    return np.concatenate([column_values(equations, name, trajectory) for name, trajectory in pairs])


def still(equations: Equations, effect: Effect, data: Dataset) -> str:
    """Which command would have to vary for an effect to show, and never does, for a sentence; "" where it does."""
    needed = (
        {effect.column: effect.body.bound} if effect.column else {name: (name,) for name in effect.searching.varying}
    )
    for name, columns in needed.items():
        known = [column for column in columns if column in (*data.layouts.action, *equations.quantities)]
        if known and not any(_varies(equations, column, data) for column in known):
            return f"{name} never varies in these logs"
    if effect.of.columns == "action" and not any(_varies(equations, name, data) for name in data.layouts.action):
        return "no command varies in these logs"
    return ""


def _varies(equations: Equations, name: str, data: Dataset) -> bool:
    values = np.concatenate([column_values(equations, name, trajectory) for trajectory in data])
    return float(np.std(values)) >= STILL


def column_values(equations: Equations, name: str, trajectory: Trajectory) -> Array:
    """A column of a log, or a quantity that the equations derive from its columns ``# (rows,)``."""
    if name not in equations.quantities:
        return trajectory.column(name)
    expression = spelled_out(equations, equations.quantities[name])
    columns = sorted(names_in(expression))
    rows = torch.as_tensor(np.stack([trajectory.column(column) for column in columns], axis=1))
    return np.asarray(compile_function([expression], [columns])(rows)[:, 0])
