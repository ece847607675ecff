"""What is left of a choice once effects have gone that predictions do not need.

The others did part of what such an effect had done, or undid it, and are fitted again without it. What was the cheapest
set of effects beyond chance need not be one any more: so an effect that is now within chance, or that has next to no
weight against none, or against another one in its place, gives way to what is cheapest there, which may be nothing.
"""

from __future__ import annotations

from collections.abc import Collection

from sym2real.diagnosis.search.effect_set import EffectSet
from sym2real.diagnosis.search.near import Near, Place
from sym2real.diagnosis.search.needed import Needed, Predicted, keep_needed
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS


def settle(predicted: Predicted) -> Needed:
    """Drop effects that predictions do not need, until the logs bear out all of the others as well."""
    selection, needed = predicted.selection, keep_needed(predicted)
    dropped, gone = needed.dropped, {candidate.name for candidate in needed.dropped}
    while gone and (place := _refuted(selection)) is not None:
        gone.add(place.candidate.name)
        instead = _in_place(selection, place, gone)
        selection.put(instead.chosen, instead.fit)
        needed = keep_needed(predicted)
        dropped += needed.dropped
        gone |= {candidate.name for candidate in needed.dropped}
    return Needed(dropped, needed.small)


def _refuted(selection: Selection) -> Place | None:
    """Of the effects that are within chance or have next to no weight in their places, the one with the least."""
    near = Near.of(selection)
    weights = near.probabilities()
    refuted = [
        place
        for place in near.places
        if weights[place.candidate.name] < SETTINGS.level or not selection.significant(selection.fit, place.candidate)
    ]
    return min(refuted, key=lambda place: weights[place.candidate.name], default=None)


def _in_place(selection: Selection, place: Place, gone: Collection[str]) -> EffectSet:
    """The cheapest of the set without an effect, and with another in its place that has not gone."""
    empty = selection.set_of([member for member in selection.chosen if member is not place.candidate], place.empty)
    others = (
        rival
        for rival in place.rivals
        if rival.candidate.name not in gone and all(selection.significant(rival.fit, each) for each in rival.chosen)
    )
    return min([empty, *others], key=lambda effects: effects.price)
