"""Effects that this data cannot tell from one that was found."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.diagnosis.search.near import Near
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.catalogue import always_alike


def groups_of(near: Near) -> dict[str, tuple[str, ...]]:
    """Per chosen effect, the rivals that explain the data as well, and those that always do."""
    selection = near.selection
    equations, chosen = selection.problems.problem.library.equations, {candidate.name for candidate in selection.chosen}
    groups = {}
    for place in near.places:
        candidate = place.candidate
        members = [*candidate.alike, *always_alike(candidate.name, equations)]
        for scored in place.rivals:
            name = scored.candidate.name
            if name not in chosen and as_good(near, place.held_out, scored.held_out):
                members += [name, *always_alike(name, equations)]
        groups[candidate.name] = tuple(dict.fromkeys(member for member in members if member != candidate.name))
    return groups


def as_good(near: Near, without: Tensor, rival: Tensor) -> bool:
    """Whether a rival explains the data as well as a finding in whose place it stands.

    It must be worth the place, too, or save nearly what a finding does that is worth it for moving little; then a
    difference that is less than what any finding needs is none, and a larger one is none where folds do not agree.

    Args:
        near: the chosen set.
        without, rival: loss per fold without the finding, and with the rival in its place ``# (folds,)``.
    """
    chosen, count, price = near.selection.held_out, len(near.selection.chosen), near.selection.price
    nearly = float((without - rival).sum()) >= SETTINGS.nearly * float((without - chosen).sum())
    if price(float(rival.sum()), count) >= price(float(without.sum()), count - 1) and not nearly:
        return False
    beyond = 1.0 - float(chosen.sum()) / float(rival.sum())
    return beyond < SETTINGS.gain_beside or float(near.weights(torch.stack([chosen, rival]))[1]) > SETTINGS.level
