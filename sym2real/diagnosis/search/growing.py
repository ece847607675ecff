"""The search: additions, then every one against dropping and against its rivals; again where it may have gone wrong.

Effects are added one by one, and the first decides what the next ones look like. Where two first effects save nearly
the same (a gain and a limit of a command that is mostly beyond the limit), the better one by a hair may be the wrong
one, and others pile up on it to make up for that. So a result that leaves much unexplained, or that many effects
explain, is not the last word: the search starts again from every first effect that was nearly as good, and the result
that predicts best for its number of effects is taken; and, if that leaves much, with other second effects than the
best, which may have bent the first to its own ends. It also starts again with a limit in the place of a gain and an
offset of the same command: together they are the straight line through a bent map. And where no single effect helps,
two may that are known to hide each other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

from sym2real.diagnosis.estimate.fit import Fit
from sym2real.diagnosis.estimate.weighing import Prepared
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.needed import keep_needed
from sym2real.diagnosis.search.pairs import add_pair
from sym2real.diagnosis.search.select import GAIN_BESIDE, Selection
from sym2real.diagnosis.stages import Stages

# Whitened squares per degree of freedom of a result that leaves nothing to explain, and the most effects that are no
# pile. First effects that save this part of what the best one does are tried as well, so many of them.
EXPLAINED, FEW = 1.05, 2
NEARLY, MOST_STARTS, MOST_ROUNDS = 0.9, 2, 3


@dataclass(frozen=True, eq=False)
class _Result:
    """What a search ended with: effects, their fit, and the held-out loss with a price for every effect."""

    chosen: list[Candidate]
    fit: Fit
    price: float

    @classmethod
    def of(cls, selection: Selection) -> _Result:
        price = selection.loss * (1 + GAIN_BESIDE) ** len(selection.chosen)
        return cls(selection.chosen, selection.fit, price)


@dataclass(frozen=True, eq=False)
class Found:
    """What a search ended with.

    Args:
        prepared: the model against checked data.
        selection: effects that are there.
        finished: whether nobody interrupted it.
    """

    prepared: Prepared
    selection: Selection
    finished: bool


def search(prepared: Prepared, stages: Stages) -> Found:
    """Let a selection without effects grow until all of them hold; Ctrl-C keeps what it is by then."""
    tried = prepared.tried
    selection = Selection(prepared.problems, tried, prepared.origin, on_progress=stages.on_progress)
    stages.try_to(f"searching among {len(tried)} effects", _grown, selection)
    needed = partial(keep_needed, library=prepared.library, logs=prepared.checked.data)
    stages.try_to("holding effects against predictions", needed, selection)
    return Found(prepared, selection, not stages.interrupted)


def _grown(selection: Selection) -> None:
    empty = selection.fit
    _from_here(selection)
    number = len(selection.chosen)
    if number < 2 or (number <= FEW and _explained(selection)):
        return
    results = [_Result.of(selection)]
    try:
        for chosen, fit in [*_other_firsts(selection, empty), *_with_limits(selection)]:
            results.append(_from(selection, chosen, fit))
        if not _explained(selection):
            for chosen, fit in _other_seconds(selection, empty):
                results.append(_from(selection, chosen, fit))
    finally:  # also for whoever ends it by Ctrl-C and keeps what is done
        best = min(results, key=lambda result: result.price)
        selection.put(best.chosen, best.fit)


def _from(selection: Selection, chosen: list[Candidate], fit: Fit) -> _Result:
    selection.put(chosen, fit)
    _from_here(selection)
    return _Result.of(selection)


def _other_firsts(selection: Selection, empty: Fit) -> list[tuple[list[Candidate], Fit]]:
    """First effects that were nearly as good as the best one."""
    best, *others = selection.ranked([], empty.values)
    nearly = [one for one in others if empty.total - one.loss > NEARLY * (empty.total - best.loss)]
    return [([one.candidate], one.fit) for one in nearly[:MOST_STARTS]]


def _other_seconds(selection: Selection, empty: Fit) -> list[tuple[list[Candidate], Fit]]:
    """The best first effect with others than the best second one, which may have bent the first to its own ends."""
    first = selection.ranked([], empty.values)[0]
    others = selection.ranked([first.candidate], first.fit.values)[1 : MOST_STARTS + 1]
    return [([first.candidate, one.candidate], one.fit) for one in others]


def _with_limits(selection: Selection) -> list[tuple[list[Candidate], Fit]]:
    """What is chosen, with a limit in the place of both gain and offset, for every command that has both."""
    names = {one.name for one in selection.chosen}
    found = []
    for limit in (one for one in selection.candidates if one.name.startswith("limit:")):
        line = {limit.name.replace("limit:", kind) for kind in ("gain:", "offset:")}
        if line <= names and limit.name not in names:
            rest = [one for one in selection.chosen if one.name not in line]
            values, slots = selection.fit.values.clone(), _slots(one for one in selection.chosen if one.name in line)
            values[slots] = selection.origin[slots]
            ranking = selection.ranked(rest, values, [limit])
            found += [([*rest, limit], ranking[0].fit)] if ranking else []
    return found


def _slots(chosen: Iterable[Candidate]) -> list[int]:
    return [slot for one in chosen for tied in one.free for slot in tied]


def _from_here(selection: Selection) -> None:
    """Grow, and hold every effect against dropping and its rivals, until that changes nothing; then fit from afresh."""
    _until_nothing_changes(selection)
    if selection.restart():
        selection.prune()


def _until_nothing_changes(selection: Selection) -> None:
    for _ in range(MOST_ROUNDS):
        before = _names(selection)
        selection.grow()
        while not _explained(selection) and add_pair(selection):
            selection.grow()
        selection.prune()
        if selection.chosen:
            selection.swap()
            selection.prune()
        if _names(selection) == before:
            return


def _explained(selection: Selection) -> bool:
    return selection.fit.total < EXPLAINED * selection.problems.whitening.freedom


def _names(selection: Selection) -> set[str]:
    return {one.name for one in selection.chosen}
