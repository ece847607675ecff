"""Two effects that hide each other: neither saves anything alone, both together do.

A car whose place is measured ahead of its rear axle seems to slide outwards of its heading in a turn, and so do soft
tyres, but inwards: at some speed neither is seen. One quadratic model with every candidate free says of each pair what
it would save, for a small system of equations; the best few are fitted.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from sym2real.diagnosis.candidates import Candidate
from sym2real.diagnosis.fit import REFIT_STEPS, Fit, Hypothesis
from sym2real.diagnosis.select import GAIN_BESIDE, MOST_FINDINGS, Selection
from sym2real.diagnosis.significance import beyond_chance

# Part of the held-out loss that two effects must leave at most, each what one beside another finding must take; and
# pairs that are fitted after the screening.
LEFT, REFITTED = (1 - GAIN_BESIDE) ** 2, 3

Pair = tuple[Candidate, Candidate]


def add_pair(selection: Selection) -> bool:
    """Add the two effects that lower the held-out loss most, if by enough and beyond chance; whether any were added."""
    if len(selection.chosen) + 2 > MOST_FINDINGS:
        return False
    problems = selection.problems
    promising = sorted(_screened(selection), key=lambda entry: entry[0])[:REFITTED]
    starts = [Hypothesis(part.free, problems.moved(part, problems.best_step(part))) for _, _, part in promising]
    fits = problems.fit(starts, REFIT_STEPS)
    losses = [float(problems.held_out(fit).sum()) for fit in fits]
    for place in sorted(range(len(fits)), key=losses.__getitem__):
        pair, fit = promising[place][1], fits[place]
        if losses[place] < LEFT * selection.loss and _beyond_chance(selection, fit, pair):
            selection.put([*selection.chosen, *pair], fit)
            return True
    return False


def _screened(selection: Selection) -> Iterator[tuple[float, Pair, Fit]]:
    """Pairs that the quadratic model about the present state promises enough of: held-out loss, pair, model."""
    problems, chosen = selection.problems, selection.chosen
    rivals = [one for one in selection.open(chosen, selection.candidates) if not one.needs_start]
    free = tuple(dict.fromkeys(selection.free([*chosen, *rivals])))
    everything = problems.quadratics([Hypothesis(free, selection.fit.values)])[0]
    places = {tied: place for place, tied in enumerate(everything.free)}
    for pair in combinations(rivals, 2):
        if _together(*pair):
            part = everything.part([places[tied] for tied in selection.free([*chosen, *pair])])
            loss = float(problems.held_out(part).sum())
            if loss < LEFT * selection.loss:
                yield loss, pair, part


def _together(first: Candidate, second: Candidate) -> bool:
    """Whether two candidates share no parameter, and neither stands for the other."""
    apart = second.name not in first.excludes and first.name not in second.excludes
    return apart and set(first.slots).isdisjoint(second.slots)


def _beyond_chance(selection: Selection, fit: Fit, pair: Pair) -> bool:
    number = selection.tried * (selection.tried - 1) // 2
    return all(beyond_chance(selection.problems, fit, one, selection.origin, number) for one in pair)
