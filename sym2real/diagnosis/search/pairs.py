"""Two effects that hide each other: neither saves much alone, both together do.

A car whose place is measured ahead of its rear axle seems to slide outwards of its heading in a turn, and with soft
tyres inwards: at some speed neither is seen. The sensitivity matrix of a set of effects says of all pairs at once what
they would save beside it, by the quadratic model about the set's fit. Any two effects explain a good deal of what
neither is, each its part; a pair that hides each other saves more than both do alone.
"""

from itertools import combinations, starmap

from sym2real.diagnosis.estimate.fit import Fit, Hypothesis
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.select import EffectSet, Selection

# Pairs that are refitted in full.
REFITTED = 2


def hidden_pairs(selection: Selection, effects: EffectSet) -> list[EffectSet]:
    """A set with each of the pairs that promise most beside its effects, the pair last."""
    problems, chosen, before = selection.problems, effects.chosen, selection.free(effects.chosen)
    candidates = [candidate for candidate in selection.open(chosen, selection.candidates) if not candidate.needs_start]
    matrix = selection.model_of_all(before, effects.fit.values, candidates)

    def part(*some: Candidate) -> Fit:
        return matrix.part((*before, *selection.free(some)))

    def left(*some: Candidate) -> float:
        return float(problems.left_out(part(*some)).sum())

    nothing, alone = left(), {candidate.name: left(candidate) for candidate in candidates}
    promising = []
    for first, second in combinations(candidates, 2):
        if selection.open([*chosen, first], [second]):
            both = left(first, second)
            apart = alone[first.name] + alone[second.name] - nothing
            if selection.price(both, len(chosen) + 2) < selection.price(min(nothing, apart), len(chosen)):
                promising.append((both, (first, second)))
    pairs = [pair for _, pair in sorted(promising, key=lambda entry: entry[0])[:REFITTED]]
    starts = ((own.free, problems.moved(own, problems.best_step(own))) for own in starmap(part, pairs))
    fits = zip(pairs, problems.fit([*starmap(Hypothesis, starts)]), strict=True)
    return [selection.set_of([*chosen, *pair], fit) for pair, fit in fits]
