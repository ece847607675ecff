"""One search over sets of effects: a beam of every size, and all that stands around the best of them.

A set costs what it leaves of logs that its fit left out, and a charge for every effect. To look around in a set is to
fit what comes of it by one more effect, the most promising of them on the set's own sensitivity matrix, and by one
less. That is done in those few sets of every size to which one effect more promises the lowest price, so that no first
effect decides what the next ones look like, unless the set is as large as the best one and even that price is higher;
and in the best set, and in it with each of its effects left out, which exchanges that effect for others. What stands
for several others keeps them out, as each of them alone, put in its place, is worse. So where all effects at once leave
less than the best set does, it is gone on from each of its effects left out, without that effect, as long as another
more or less is cheaper. The search ends where all of these have been looked around in and, as a set may have several
valleys, fitted anew from the other starts of their effects. The answer is the cheapest set of which every effect is
beyond chance. Sets on the way need not be: while much is missing, errors are large, and no test tells. Sets that cost
less than the answer have effects that are not beyond chance; the cheapest of every size are looked around in what they
are without one of these. Where no single effect helps, two may that hide each other. The best of some hundred pairs
saves something by luck, so what a pair saves must be beyond its standard error.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, groupby, islice
from math import inf

from sym2real.diagnosis.estimate.fit import Hypothesis
from sym2real.diagnosis.estimate.preparation import Prepared, uncalibrated
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.needed import Predicted
from sym2real.diagnosis.search.pairs import hidden_pairs
from sym2real.diagnosis.search.select import BETTER, EffectSet, Selection, parameter_set
from sym2real.diagnosis.search.settled import join_narrow, settle
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.commands import GAIN
from sym2real.stages import OnProgress, Stages

# Cheapest sets of a size of which it is asked what one effect more promises, and those that are looked around in.
SCREENED, WIDTH = 4, 2
UNNEEDED = "beyond chance, but no prediction needs it, and whole logs do not establish it"
TOO_LARGE = "not taken, because its fit lies at the end of what is likely"

Names = frozenset[str]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What a search ended with.

    Args:
        prepared: the model against checked data.
        selection: effects that are there.
        finished: whether nobody interrupted it.
        dropped: effects that are beyond chance, and that predictions do not need.
    """

    prepared: Prepared
    selection: Selection
    finished: bool
    dropped: tuple[Candidate, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the data and the method, and effects that were not taken though the logs ask for them."""
        not_taken = {UNNEEDED: [own.name for own in self.dropped], TOO_LARGE: self.selection.driven_to_bounds()}
        return (*self.prepared.notes, *(f"{why}: {', '.join(names)}" for why, names in not_taken.items() if names))

    def gains(self, commands: Collection[str]) -> dict[str, float]:
        """Of these commands, whether or not they are beyond chance; nothing of one whose gain does not compete."""
        selection, problems = self.selection, self.selection.problems
        keys = {f"{GAIN.name}:{command}": command for command in commands}
        own = {candidate: problems.library.key(candidate.name) for candidate in selection.candidates}
        more = [c for c in selection.open(selection.chosen, selection.candidates) if own[c] in keys]
        chosen = [*selection.chosen, *more]
        (fit,) = problems.fit([Hypothesis(selection.free(chosen), selection.fit.values)])
        values = parameter_set(selection, chosen, fit.values)
        return {keys[own[c]]: float(values[c.slots[0]]) for c in chosen if own.get(c) in keys}

    def suspects(self) -> dict[str, float]:
        """Effects of which each explains nearly all that is left beside what was found, and that part; the best first.

        They save as much of what they have not seen as an effect must of few logs.

        They were not taken because too few independent pieces of the logs tell of them.
        """
        selection, suspects = self.selection, dict[str, float]()
        excess = selection.fit.total - selection.problems.whitening.freedom
        for larger in selection.larger(selection.present) if excess > 0 else ():
            explained = min(1.0, (selection.fit.total - larger.fit.total) / excess)
            inside = not selection.at_bound(larger.fit, larger.candidate)
            saves = explained >= SETTINGS.nearly and larger.loss < (1 - SETTINGS.gain_few) * selection.present.loss
            if inside and saves and not selection.significant(larger.fit, larger.candidate):
                suspects.setdefault(selection.problems.problem.library.key(larger.candidate.name), explained)
        return suspects


def search(prepared: Prepared, stages: Stages) -> SearchResult:
    """The effects that are there and that predictions need; Ctrl-C keeps what is found by then.

    A base as it is comes before a calibrated one where it surely costs so much less, with the effect that helps most
    or none; the other in doubt.
    """
    known = (prepared, *([uncalibrated(prepared)] if prepared.calibrated else ()))
    ways = [(way, Selection(way.problems, way.candidates, way.origin)) for way in known]
    if len(ways) > 1 and stages.try_to("holding the base against its simulator", _contradicted, ways):
        ways.reverse()
    (prepared, selection), *others = ways
    if not stages.interrupted:
        _search(prepared, selection, stages)
    for other, second in others:
        if not stages.interrupted and _doubtful(selection, second, other):
            _search(other, second, stages)
            if second.surely_cheaper(second.present, selection.present):
                prepared, selection = other, second
    predicted = Predicted(selection, prepared.library, prepared.checked.data)
    dropped = stages.try_to("holding effects against predictions", settle, predicted)
    if dropped is not None:
        stages.try_to("searching for what moves little of what is measured", join_narrow, predicted)
        selection.small = predicted.small()
    return SearchResult(prepared, selection, not stages.interrupted, dropped or ())


def _search(prepared: Prepared, selection: Selection, stages: Stages) -> None:
    beam = Beam(selection, stages.on_progress, float(prepared.problems.totals([prepared.full_fit])))
    stages.try_to(f"searching among {len(prepared.candidates)} effects", Beam.search, beam)


def _contradicted(ways: Sequence[tuple[Prepared, Selection]]) -> bool:
    """Whether the second of two ways surely costs so much less, without effects or with the one that helps most."""
    looked = ([own.present, *own.larger(own.present)] for _, own in ways)
    first, second = (min(sets, key=lambda effects: effects.price) for sets in looked)
    return _cheaper(second, first) and ways[1][1].surely_cheaper(second, first)


def _doubtful(searched: Selection, second: Selection, other: Prepared) -> bool:
    """Whether what was found costs less beside the base as the other way has it, or all effects at once leave less
    beside the base as it is, by as much as an effect must save: a simulator's wheels sink in where a robot's may not.
    """
    if _cheaper(second.beside(searched.chosen, searched.fit), searched.present):
        return True
    left = float(other.problems.totals([other.full_fit]))
    return not other.calibrated and left < (1.0 - SETTINGS.another_effect) * searched.present.fit.total


def _cheaper(effects: EffectSet, others: EffectSet) -> bool:
    return effects.price < (1.0 - SETTINGS.gain) * others.price


@dataclass(eq=False)
class Beam:
    """All sets that were fitted, and which of them were looked around in.

    Args:
        selection: what competes; it becomes the best set.
        on_progress: called with what has been found so far.
        least: whitened squares of all segments that all effects at once leave.
    """

    selection: Selection
    on_progress: OnProgress = lambda _: None
    least: float = 0.0
    sets: dict[Names, EffectSet] = field(default_factory=dict)
    looked_around: set[Names] = field(default_factory=set)
    fitted_anew: set[Names] = field(default_factory=set)
    _left_out: set[tuple[Names, Names]] = field(default_factory=set)

    def search(self) -> None:
        """Look around until there is nothing left to; whoever ends it by Ctrl-C keeps the best set so far."""
        self._keep(self.selection.present)
        try:
            while (effects := next(self._waiting(), None)) is not None or self._fitted_better():
                if effects is not None:
                    self._look_around(effects)
                if names := [member.name for member in self._best().chosen]:
                    self.on_progress(f"found so far: {', '.join(names)}; searching on")
        finally:
            best = self._best()
            self.selection.put(best.chosen, best.fit)

    def _waiting(self) -> Iterator[EffectSet]:
        """Sets that are still to be looked around in, those of the beam first."""
        best = self._best()
        for size, same in self._by_size():
            cheapest = islice(filter(self._worth_its_size, same), SCREENED)
            for effects in sorted(cheapest, key=self.selection.promise)[:WIDTH]:
                beyond = size < len(best.chosen) or self.selection.promise(effects) < best.price
                if beyond and effects.names not in self.looked_around:
                    yield effects
        centres = chain(self._around(best), self._towards_significance(best), self._descents(best))
        yield from (effects for effects in centres if effects.names not in self.looked_around)

    def _by_size(self) -> Iterator[tuple[int, Iterator[EffectSet]]]:
        """All sets of every size, the cheapest first."""
        ordered = sorted(self.sets.values(), key=lambda effects: (len(effects.chosen), effects.price))
        return groupby(ordered, key=lambda effects: len(effects.chosen))

    def _around(self, centre: EffectSet) -> Iterator[EffectSet]:
        """A set, and it with each of its effects left out."""
        yield centre
        yield from (self._without(centre, left_out) for left_out in centre.chosen)

    def _towards_significance(self, best: EffectSet) -> Iterator[EffectSet]:
        """Of cheaper sets than the best one, what they are without one of the effects that are not beyond chance."""
        for _, same in self._by_size():
            cheaper = (other for other in same if other.price < best.price and self._worth_its_size(other))
            for effects in list(islice(cheaper, WIDTH)):
                doubtful = [member for member in effects.chosen if not self.selection.significant(effects.fit, member)]
                without = [self._without(effects, member) for member in doubtful]
                yield from sorted(without, key=lambda other: other.price)[:1]

    def _descents(self, best: EffectSet) -> Iterator[EffectSet]:
        """From the best set without one of its effects to ever cheaper ones without it, if less can be left at all."""
        if best.fit.total * (1 - SETTINGS.gain_beside) <= self.least:
            return
        for left_out in best.chosen:
            effects, last = self._without(best, left_out), inf
            while effects.price < last:
                yield effects
                near = (other for other in self.sets.values() if len(other.names ^ effects.names) == 1)
                near = (other for other in near if left_out.name not in other.names)
                effects, last = min(near, key=lambda other: other.price, default=effects), effects.price

    def _without(self, effects: EffectSet, left_out: Candidate) -> EffectSet:
        names = effects.names - {left_out.name}
        if (effects.names, names) not in self._left_out:
            self._left_out.add((effects.names, names))
            self._keep(self.selection.without(effects, left_out))
        return self.sets[names]

    def _worth_its_size(self, effects: EffectSet) -> bool:
        """Whether no set that is known with one effect less is as cheap."""
        return all(effects.price < self.sets[names].price for names in effects.smaller if names in self.sets)

    def _best(self) -> EffectSet:
        """The cheapest set that is beyond chance; of a search that has just begun with others, the cheapest."""
        by_price = sorted(self.sets.values(), key=lambda effects: effects.price)
        holding = (effects for effects in by_price if self._worth_its_size(effects) and self.selection.holds(effects))
        return next(holding, by_price[0])

    def _look_around(self, effects: EffectSet) -> None:
        self.looked_around.add(effects.names)
        for left_out in effects.chosen:
            if self.selection.predicted_without(effects, left_out) < effects.price:
                self._without(effects, left_out)
        for larger in self.selection.larger(effects) if len(effects.chosen) < SETTINGS.most_findings else []:
            self._keep(larger)
        larger_sets = (other for other in self.sets.values() if effects.names < other.names)
        if len(effects.chosen) + 2 <= SETTINGS.most_findings and not any(map(self._worth_its_size, larger_sets)):
            for larger in hidden_pairs(self.selection, effects):
                significant = all(self.selection.significant(larger.fit, member) for member in larger.chosen[-2:])
                if significant and self.selection.surely_cheaper(larger, effects):
                    self._keep(larger)

    def _fitted_better(self) -> bool:
        """Whether the best set, or it with one effect left out, has a better fit from other starts of its effects."""
        better = False
        for effects in list(self._around(self._best())):
            if effects.names not in self.fitted_anew:
                self.fitted_anew.add(effects.names)
                for fitted in self.selection.fitted_anew(effects):
                    self._keep(fitted)
                if self.sets[effects.names] is not effects:
                    self.looked_around.discard(effects.names)
                    better = True
        return better

    def _keep(self, effects: EffectSet) -> None:
        """Remember a set; of one that is known the better fit."""
        known = self.sets.get(effects.names)
        if known is None or effects.fit.total < (1 - BETTER) * known.fit.total:
            self.sets[effects.names] = effects
            self.selection.forget(effects.names)
            self._left_out = {asked for asked in self._left_out if asked[0] != effects.names}
