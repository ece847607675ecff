"""The sets of effects around the one that was chosen, and their weights: none, or another, in an effect's place.

A set is weighted by how it predicts folds that its fit left out, by pseudo-Bayesian model averaging with the Bayesian
bootstrap over folds: Y. Yao, A. Vehtari, D. Simpson, A. Gelman, "Using stacking to average Bayesian predictive
distributions", Bayesian Analysis 13 (2018). Whole folds are drawn, so that neither residuals that follow each other nor
a log unlike the others make a weight surer than it is; and no effect needs a prior probability.
Whitened squares are divided by those of the chosen set per degree of freedom where these are more than one. Those of
sets that leave nearly as little have the free starts of segments move these as their own values say (a start is a
nuisance parameter of every hypothesis: profile likelihood).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import torch
from torch import Tensor

from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.select import EffectSet, Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.catalogue import always_alike

DRAWS = 2000
# Sets further away that are looked at, the cheapest.
FURTHER = 6


@dataclass(frozen=True, eq=False)
class Place:
    """An effect's place in the chosen set.

    Args:
        candidate: the effect.
        empty: the others alone.
        alternatives: what was fitted in the effect's place, inside its bounds, best first; what surely costs less
            beside the effect, or leaves it most of what it saves, is not in its place.
        outdone: whether something at the end of what is likely costs surely less there than the chosen set, which does
            not save nearly as much.
    """

    candidate: Candidate
    empty: EffectSet
    alternatives: Sequence[EffectSet]
    outdone: bool

    @property
    def sets(self) -> list[EffectSet]:
        """Without the effect, and with another one in its place."""
        return [self.empty, *self.alternatives]

    @property
    def worth_it(self) -> list[EffectSet]:
        """Alternatives that cost less than none in the effect's place."""
        return [other for other in self.alternatives if other.price < self.empty.price]


@dataclass(frozen=True, eq=False)
class Near:
    """A chosen set of effects and those around it.

    Args:
        selection: the chosen set.
        places: of its effects.
        present: the chosen set, by its own starts.
        larger: it with one more effect that is beyond chance, whether that is worth its charge or not.
        elsewhere: the cheapest of all sets further away, whose effects are beyond chance.
    """

    selection: Selection
    places: tuple[Place, ...]
    present: EffectSet
    larger: Sequence[EffectSet] = ()
    elsewhere: Sequence[EffectSet] = ()

    @classmethod
    def of(cls, selection: Selection) -> Near:
        """Every effect of the set left out, and every alternative that is worth a fit put in its place."""
        around = cls.at(selection, *selection.chosen)
        sure = [more for more in selection.larger(selection.present) if selection.significant(more.fit, more.candidate)]
        return replace(around, larger=by_price(selection, sure))

    @classmethod
    def at(cls, selection: Selection, *candidates: Candidate) -> Near:
        """The same of some effects' places alone."""
        present = by_own_starts(selection, selection.present)
        return cls(selection, tuple(_place(selection, candidate, present) for candidate in candidates), present)

    def with_elsewhere(self) -> Near:
        """The same with sets that are not around, of which two effects are others, as a gain and a delay for play and a
        lag, or one that is not in the place of another (see :class:`Place`). More effects for fewer are no others.
        """
        selection, around = self.selection, [*self.larger, *(own for place in self.places for own in place.sets)]
        here = {self.present.names, *(effects.names for effects in around)}
        ordered = sorted(selection.known.values(), key=lambda effects: effects.price)
        small = (effects for effects in ordered if len(effects.chosen) <= len(self.present.chosen))
        further = (effects for effects in small if effects.names not in here and selection.holds(effects))
        return replace(self, elsewhere=by_price(selection, list(islice(further, FURTHER))))

    def unlikely(self) -> list[Place]:
        """Places that something at the end of what is likely takes, or whose effects have next to no weight there."""
        weights = self.probabilities()
        return [own for own in self.places if own.outdone or weights[own.candidate.name] < SETTINGS.level]

    def probabilities(self, groups: Mapping[str, Collection[str]] | None = None) -> dict[str, float]:
        """By effect, the chosen set's weight among those with it, without it, or with another in its place.

        With the weight of those others that are in its group.
        """
        return {place.candidate.name: self._weight(place, groups or {}) for place in self.places}

    def _weight(self, place: Place, groups: Mapping[str, Collection[str]]) -> float:
        sets, name = [self.present, *place.sets, *self.elsewhere], place.candidate.name
        others, weights = {*groups.get(name, ())}, self.weights(*(effects.held_out for effects in sets))
        alike = [name in own.names or not others.isdisjoint(own.names - self.present.names) for own in sets]
        return float(weights[torch.tensor(alike)].sum())

    def sets_with(self, candidate: Candidate) -> tuple[list[EffectSet], Tensor]:
        """Those that have an effect and differ elsewhere, the chosen one first, and their weights among them."""
        others = [place for place in self.places if place.candidate is not candidate]
        sets = [self.present, *self.larger, *(own for place in others for own in place.sets)]
        sets += [effects for effects in self.elsewhere if candidate in effects.chosen]
        return sets, self.weights(*(effects.held_out for effects in sets))

    def weights(self, *losses: Tensor) -> Tensor:
        """Weights of sets ``# (sets,)`` by the losses per fold of each ``# (folds,)``."""
        whitening = self.selection.problems.whitening
        evidence = -0.5 * torch.stack(losses) / max(1.0, self.selection.fit.total / whitening.freedom)
        folds = evidence.shape[1]
        drawn = torch.as_tensor(np.random.default_rng(0).dirichlet(np.ones(folds), DRAWS)) * folds
        return torch.softmax(drawn @ evidence.T, dim=1).mean(0)


def _place(selection: Selection, candidate: Candidate, present: EffectSet) -> Place:
    """The place of an effect of the present set."""
    rest = selection.without(selection.present, candidate)
    others = [other for other in selection.larger(rest) if other.candidate is not candidate]
    others = [other for other in others if not left_its_part(selection, candidate, rest, other)]
    inside = [other for other in others if not selection.at_bound(other.fit, other.candidate)]
    ends = [by_own_starts(selection, other) for other in others if other not in inside]
    empty = by_own_starts(selection, rest)
    outdone = any(selection.surely_cheaper(other, present) and not _nearly(present, other, empty) for other in ends)
    return Place(candidate, empty, by_price(selection, inside), outdone)


def left_its_part(selection: Selection, own: Candidate, rest: EffectSet, other: EffectSet) -> bool:
    """Whether an effect is needed beside a set, whose effects are not in its place: with it the set costs surely less,
    or most of what it saves beside the rest of the present one it saves there.
    """
    other, rest = (selection.known.get(effects.names, effects) for effects in (other, rest))
    both = selection.known.get(other.names | {own.name}) or selection.beside([*other.chosen, own], other.fit)
    saved = SETTINGS.mostly * (rest.loss - selection.present.loss)
    return selection.surely_cheaper(both, other) or 0 < saved <= other.loss - both.loss


def _nearly(effects: EffectSet, other: EffectSet, fewer: EffectSet) -> bool:
    """Whether a set saves nearly what another does beside one with fewer effects."""
    return fewer.price - effects.price >= SETTINGS.nearly * (fewer.price - other.price)


def by_own_starts(selection: Selection, effects: EffectSet) -> EffectSet:
    """A set by its own starts, unless it leaves so much more than the chosen one that starts do not matter."""
    if effects.loss > (1 + SETTINGS.worth_saying) * selection.present.loss:
        return effects
    held_out = effects.held_out + selection.problems.by_own_starts(effects.fit)
    return replace(effects, held_out=held_out, price=selection.price(float(held_out.sum()), len(effects.chosen)))


def by_price(selection: Selection, sets: Sequence[EffectSet]) -> list[EffectSet]:
    """Sets by their own starts, the cheapest first."""
    return sorted((by_own_starts(selection, effects) for effects in sets), key=lambda effects: effects.price)


def groups_of(near: Near) -> dict[str, tuple[str, ...]]:
    """Per chosen effect, the alternatives that explain the data as well, and those that always do.

    In sets that differ in several effects, what may take an effect's place alone takes it there; the rest is in the
    places of those of which that is not known.
    """
    library, chosen = near.selection.problems.problem.library, near.present.names
    alone = {place.candidate.name: {other.candidate.name for other in place.alternatives} for place in near.places}
    groups = {}
    for place in near.places:
        own, members = place.candidate.name, list(place.candidate.alike)
        for other in (other for other in (*place.alternatives, *near.elsewhere) if own not in other.names):
            joined, gone = other.names - chosen, chosen - other.names
            needed = left_its_part(near.selection, place.candidate, place.empty, other)
            if not needed and as_good(near, place.empty.held_out, other.held_out):
                members += sorted(alone[own] & joined or joined.difference(*(alone[name] for name in gone)))
        members = [key for name in (own, *members) for key in (name, *always_alike(name, library.equations))]
        # What the equations name themselves is what a user can look up.
        members.sort(key=lambda name: name not in library.effects or library.effects[name].given is None)
        groups[own] = tuple(dict.fromkeys(member for member in members if member != own))
    return groups


def as_good(near: Near, without: Tensor, alternative: Tensor) -> bool:
    """Whether an alternative explains the data as well as a finding in whose place it stands.

    It must be worth the place, too, or save nearly what a finding does that is worth it for moving little; then a
    difference that is less than what any finding needs is none, and a larger one is none where folds do not agree.

    Args:
        near: the chosen set.
        without, alternative: loss per fold without the finding, and with the alternative in its place ``# (folds,)``.
    """
    chosen, count, price = near.present.held_out, len(near.selection.chosen), near.selection.price
    nearly = float((without - alternative).sum()) >= SETTINGS.nearly * float((without - chosen).sum())
    if price(float(alternative.sum()), count) >= price(float(without.sum()), count - 1) and not nearly:
        return False
    beyond = 1.0 - float(chosen.sum()) / float(alternative.sum())
    return beyond < SETTINGS.gain_beside or float(near.weights(chosen, alternative)[1]) > SETTINGS.level
