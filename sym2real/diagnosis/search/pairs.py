"""Two effects that are known to hide each other: neither saves anything alone, both together do.

A car whose place is measured ahead of its rear axle seems to slide outwards of its heading in a turn, and with soft
tyres inwards: at some speed neither is seen. So it is with a steering that turns too far and a front axle that gives
way. Any two effects would explain a good deal of what neither is: with all pairs allowed, a force of the wind tunnel
was 0.6 m/s² off, and of the answers with nothing left over a quarter were wrong where an effect was not in the library.
"""

from __future__ import annotations

from sym2real.diagnosis.estimate.fit import REFIT_STEPS, Hypothesis
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.select import GAIN_BESIDE, MOST_FINDINGS, Selection

KNOWN = (("lever_arm", "tyre_slip"), ("gain:steer", "understeer"))
# Part of the held-out loss that two effects must leave at most: each takes what one beside another finding must.
LEFT = (1 - GAIN_BESIDE) ** 2

Pair = tuple[Candidate, Candidate]


def add_pair(selection: Selection) -> bool:
    """Add the two effects that lower the held-out loss most, if by enough and beyond chance; whether any were added."""
    problems, pairs = selection.problems, _open(selection)
    starts = [_start(selection, pair) for pair in pairs]
    fits = problems.fit(starts, REFIT_STEPS)
    losses = [float(problems.held_out(fit).sum()) for fit in fits]
    for place in sorted(range(len(fits)), key=losses.__getitem__):
        if losses[place] < LEFT * selection.loss and all(
            selection.significant(fits[place], one) for one in pairs[place]
        ):
            selection.put([*selection.chosen, *pairs[place]], fits[place])
            return True
    return False


def _open(selection: Selection) -> list[Pair]:
    """The known pairs of which neither is found nor stands for what is."""
    if len(selection.chosen) + 2 > MOST_FINDINGS:
        return []
    rivals = {one.name: one for one in selection.open(selection.chosen, selection.candidates)}
    return [(rivals[first], rivals[second]) for first, second in KNOWN if first in rivals and second in rivals]


def _start(selection: Selection, pair: Pair) -> Hypothesis:
    """Where the quadratic model about the present state has its minimum with both free."""
    problems, free = selection.problems, selection.free([*selection.chosen, *pair])
    fit = problems.quadratics([Hypothesis(free, selection.fit.values)])[0]
    return Hypothesis(free, problems.moved(fit, problems.best_step(fit)))
