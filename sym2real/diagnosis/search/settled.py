"""What is left of a choice once effects have gone that predictions do not need, or that the sets around it refute.

The others did part of what such an effect had done, or undid it, and are fitted again without it. What was the cheapest
set of effects beyond chance need not be one any more: predictions may need what explained the logs nearly as well as
one that has gone, as a servo's lag in place of an arm. And it is one set among those near it: an effect beyond chance
beside some effects alone is not there for sure. So an effect that is within chance, that has next to no weight against
none or another one in its place, that one at the end of what is likely outdoes there, or that is none within its
intervals, which cover the choice of the effects beside it, gives way to what is cheapest there, which may be nothing.

Beside what stands, effects are put at last that move few of the measured directions.
"""

from collections.abc import Collection, Iterator, Sequence
from copy import copy
from functools import partial

from sym2real.diagnosis.estimate.significance import least_gain
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.intervals import none_within
from sym2real.diagnosis.search.near import Near, Place, by_own_starts
from sym2real.diagnosis.search.needed import Predicted, keep_needed
from sym2real.diagnosis.search.select import PROMISING, EffectSet, Selection, parameter_set
from sym2real.diagnosis.settings import SETTINGS


def settle(predicted: Predicted) -> tuple[Candidate, ...]:
    """Drop effects that predictions do not need, and those that the logs do not bear out, until all others stand.

    Those that predictions do not need are returned.

    What is refuted beside some effects need not be beside others: a delay beside play gives way to a lag, and stands
    beside a gain. So a plainer set further away that costs no more takes the place of what stands if it stands, too,
    and predicts no worse.
    """
    selection, dropped = predicted.selection, _settled(predicted, predicted.selection.present)
    near = Near.of(selection).with_elsewhere()
    if (other := plainer_set(near, near.elsewhere)) is not None:
        instead = _settled(predicted, other)
        plainer = plainer_set(near, [by_own_starts(selection, selection.present)])
        if plainer is not None and predicted.no_worse(plainer, near.present):
            return instead
        selection.put(near.present.chosen, near.present.fit)
    return dropped


def _settled(predicted: Predicted, more: EffectSet | None) -> tuple[Candidate, ...]:
    selection, dropped, seen = predicted.selection, tuple[Candidate, ...](), frozenset[str]()
    while more is not None:
        selection.put(more.chosen, more.fit)
        seen |= more.names
        dropped += keep_needed(predicted)
        gone = seen - selection.present.names
        more = predicted.needs_most(_asked_again(selection, gone)) or _instead(Near.of(selection), gone)
    return dropped


def _asked_again(selection: Selection, gone: Collection[str]) -> list[EffectSet]:
    """Sets with one effect more that are cheaper and beyond chance, once others have gone."""
    present = selection.present
    cheaper = [larger for larger in selection.larger(present) if larger.price < present.price] if gone else []
    return [*_standing(selection, cheaper, gone)]


def _instead(near: Near, gone: Collection[str]) -> EffectSet | None:
    """What takes the place of an effect that the logs do not bear out, or of one that is not plain; None otherwise."""
    place = refuted(near, gone)
    exchanged = [other for around in near.places for other in around.worth_it]
    return plainer_set(near, exchanged, gone) if place is None else _in_place(near.selection, place, gone)


def plainer_set(near: Near, sets: Sequence[EffectSet], gone: Collection[str] = ()) -> EffectSet | None:
    """The cheapest of sets that are plainer than the present one, if that saves no more than the standard error.

    A torque about each axis does what a weak rotor does. The one-standard-error rule: L. Breiman et al.,
    "Classification and Regression Trees", 1984, section 3.4.3.
    """
    selection, most = near.selection, near.selection.complexity(near.present)
    plainer = [other for other in sets if selection.complexity(other) < most]
    alike = [other for other in plainer if not selection.surely_cheaper(near.present, other)]
    return next(_standing(selection, alike, gone), None)


def refuted(near: Near, gone: Collection[str] | None = None) -> Place | None:
    """Of the effects that the logs do not bear out, the one with the least weight in its place.

    Where it is said which have ``gone``, also of those in whose place another one that has not costs less; a threshold
    (see ``beam.py``) or one parameter more (:func:`plainer_set`) costs less there only by more than chance, and takes
    no place.
    """
    selection, weights, present, unlikely = near.selection, near.probabilities(), near.present, near.unlikely()

    def costs_less(place: Place) -> bool:
        instead = present if gone is None else _in_place(selection, place, gone)
        cheaper = instead.price < present.price and len(instead.chosen) == len(present.chosen)
        return cheaper and selection.complexity(instead) <= selection.complexity(present)

    doubtful = [
        place
        for place in near.places
        if place in unlikely
        or not selection.significant(selection.fit, place.candidate)
        or none_within(near, place.candidate)
        or costs_less(place)
    ]
    return min(doubtful, key=lambda place: weights[place.candidate.name], default=None)


def _in_place(selection: Selection, place: Place, gone: Collection[str]) -> EffectSet:
    """The cheapest of the set without an effect, and with another in its place that has not gone."""
    return next(_standing(selection, place.worth_it, gone), place.empty)


def _standing(selection: Selection, sets: Sequence[EffectSet], gone: Collection[str]) -> Iterator[EffectSet]:
    """Sets whose last effect has not gone, and whose every effect is beyond chance, the cheapest first."""
    remaining = (effects for effects in sets if effects.candidate.name not in gone)
    return filter(selection.holds, sorted(remaining, key=lambda effects: effects.price))


def join_narrow(predicted: Predicted) -> None:
    """Put effects that move few of the measured directions beside what was chosen.

    Such an effect pays less than others, so an error must surely be a tenth larger without it or whole logs establish
    it, no error may be larger with it, and the sets around must refute none: it could displace another one.
    """
    selection = predicted.selection
    while (larger := next(filter(partial(_stands, predicted), _narrow(selection)), None)) is not None:
        selection.put(larger.chosen, larger.fit)


def _stands(predicted: Predicted, larger: EffectSet) -> bool:
    selection = copy(predicted.selection)
    selection.put(larger.chosen, larger.fit)
    # Its own place refutes most of them, and all places take ten times as long.
    alone = predicted.bears_out(larger) and not Near.at(selection, larger.candidate).unlikely()
    return alone and refuted(Near.of(selection)) is None


def _narrow(selection: Selection) -> Iterator[EffectSet]:
    """Sets with one effect more that takes its part off the loss of what it moves, best first.

    During the search all effects have one price: which of two alternatives explains more is no matter of directions. A
    lag below the base's own is reported as none, and is none.
    """
    problems, count = selection.problems, len(selection.chosen) + 1
    if count > SETTINGS.most_findings:
        return
    reference, screened = selection.screening(selection.present)
    most = (1 - PROMISING * SETTINGS.gain_of(count) / len(problems.whitening.sensor)) * reference
    smooth = [(other, start) for loss, other, start in screened if loss < most and not other.needs_start]
    for larger in selection.refitted(selection.chosen, smooth):
        reported, slots = parameter_set(selection, larger.chosen, larger.fit.values), larger.candidate.slots
        least = least_gain(problems, larger.candidate, larger.fit.values, count)
        there = bool((reported != problems.library.null)[slots].any())
        if there and larger.loss < (1 - least) * selection.present.loss and selection.holds(larger):
            yield larger
