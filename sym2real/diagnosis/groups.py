"""Effects that this data cannot tell from one that was found."""

from __future__ import annotations

from fnmatch import fnmatch

import torch

from sym2real.diagnosis.candidates import STANDS_FOR
from sym2real.diagnosis.select import Scored, Selection
from sym2real.effects import same_group

# A rival of the same group: share of the finding's gain, paired t over folds, share that needs no test.
SHARE, PAIRED_T, NEARLY_ALL = 0.8, 2.5, 0.97


def groups_of(selection: Selection) -> dict[str, tuple[str, ...]]:
    """Per chosen effect, the rivals that explain the data as well, and those that always do."""
    if not selection.chosen:
        return {}
    rivals = selection.swap()
    found = {}
    for one in selection.chosen:
        members = list(always_alike(one.name, selection))
        for scored, share, difference in rivals.get(one.name, []):
            name = scored.candidate.name
            if name in {other.name for other in selection.chosen}:
                continue
            if as_good(share, difference):
                members += [name, *always_alike(name, selection)]
        found[one.name] = tuple(dict.fromkeys(member for member in members if member != one.name))
    return found


def as_good(share: float, difference: torch.Tensor) -> bool:
    """Whether a rival explains the data as well: its share of the gain, and its loss beyond by fold ``# (folds,)``."""
    return share > SHARE and (share > NEARLY_ALL or _paired(difference) < PAIRED_T)


def always_alike(name: str, selection: Selection) -> list[str]:
    """Effects that stand for this one on every flight."""
    equations = selection.problems.problem.library.equations
    patterns = STANDS_FOR.get(name, ())
    actions = [f"{kind}:{column}" for kind in ("gain", "offset") for column in equations.layouts.action]
    actions += [f"{kind}:thrust" for kind in ("gain", "offset") if "thrust" in equations.quantities]
    known = [*actions, "slope", "wheelbase"]
    planar = "z" not in equations.layouts.state
    if not planar:
        known = [key for key in known if key not in ("slope", "wheelbase")]
    return [key for key in known if any(fnmatch(key, pattern) for pattern in patterns)]


def _paired(difference: torch.Tensor) -> float:
    """t of the rivals' losses less the finding's, over folds."""
    if len(difference) < 2:
        return 0.0
    spread = float(difference.std()) / float(len(difference)) ** 0.5
    return float(difference.mean()) / max(float(spread), 1e-12)


__all__ = ["Scored", "groups_of", "same_group"]
