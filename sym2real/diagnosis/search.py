"""The search: additions, then every one against dropping and against its rivals; again where it may have gone wrong.

Effects are added one by one, and the first decides what the next ones look like. Where two first effects save nearly
the same (a gain and a limit of a command that is mostly beyond the limit), the better one by a hair may be the wrong
one, and others pile up on it to make up for that. So a result that leaves much unexplained is not the last word: the
search starts again from every first effect that was nearly as good, and the result that predicts best is taken. It
also starts again with a limit in the place of a gain and an offset of the same command: together they are the straight
line through a bent map.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from sym2real.diagnosis.candidates import Candidate
from sym2real.diagnosis.fit import Fit
from sym2real.diagnosis.select import GAIN_BESIDE, Selection

# Whitened squares per degree of freedom of a result that leaves nothing to explain. First effects that save this part
# of what the best one does are tried as well, so many of them.
EXPLAINED, NEARLY, MOST_STARTS = 1.05, 0.9, 2


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


def search(selection: Selection) -> None:
    """Let a selection without effects grow until all of them hold; its state is the result."""
    empty = selection.fit
    _from_here(selection)
    explained = EXPLAINED * selection.problems.whitening.freedom
    if len(selection.chosen) < 2 or selection.fit.total < explained:
        return
    results = [_Result.of(selection)]
    ranking = selection.ranked([], empty.values)
    nearly = [one for one in ranking[1:] if empty.total - one.loss > NEARLY * (empty.total - ranking[0].loss)]
    again = [([first.candidate], first.fit) for first in nearly[:MOST_STARTS]] + _with_limits(selection)
    for chosen, fit in again:
        selection.put(chosen, fit)
        _from_here(selection)
        results.append(_Result.of(selection))
    best = min(results, key=lambda result: result.price)
    selection.put(best.chosen, best.fit)


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
    selection.grow()
    selection.prune()
    if selection.chosen:
        selection.swap()
        selection.prune()
