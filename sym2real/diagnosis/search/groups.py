"""Effects that this data cannot tell from one that was found."""

from __future__ import annotations

import torch

from sym2real.diagnosis.search.near import Near
from sym2real.diagnosis.search.select import GAIN
from sym2real.effects.catalogue import always_alike

# A rival of the same group saves this share of what the finding saves, and leaves no more loss than this beyond it,
# relative; the larger one only where folds do not agree on who is better, by a paired t.
SHARE, PAIRED_T, AT_MOST = 0.8, 2.5, 0.1


def groups_of(near: Near) -> dict[str, tuple[str, ...]]:
    """Per chosen effect, the rivals that explain the data as well, and those that always do."""
    selection = near.selection
    equations, chosen = selection.problems.problem.library.equations, {one.name for one in selection.chosen}
    found = {}
    for place in near.places:
        one = place.one
        members = [*one.alike, *always_alike(one.name, equations)]
        gain = max(float((place.held_out - selection.held_out).sum()), 1e-12)
        for scored in place.rivals:
            name, share = scored.candidate.name, float((place.held_out - scored.held_out).sum()) / gain
            if name not in chosen and as_good(share, scored.held_out - selection.held_out, selection.loss):
                members += [name, *always_alike(name, equations)]
        found[one.name] = tuple(dict.fromkeys(member for member in members if member != one.name))
    return found


def as_good(share: float, difference: torch.Tensor, loss: float) -> bool:
    """Whether a rival explains the data as well: by less than the gain that any finding needs, it makes no difference.

    Args:
        share: of the finding's gain.
        difference: the rival's loss less the finding's, by fold ``# (folds,)``.
        loss: the finding's.
    """
    beyond = float(difference.sum()) / max(loss, 1e-12)
    return share > SHARE and (beyond < GAIN or (beyond < AT_MOST and _paired(difference) < PAIRED_T))


def _paired(difference: torch.Tensor) -> float:
    """t of the rivals' losses less the finding's, over folds."""
    if len(difference) < 2:
        return 0.0
    spread = float(difference.std()) / float(len(difference)) ** 0.5
    return float(difference.mean()) / max(float(spread), 1e-12)
