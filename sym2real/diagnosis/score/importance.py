"""In which order findings matter: by how much worse free predictions are without each.

The whitened loss that the search works with says how sure an effect is; a tiny effect on a quiet axis is very sure.
What matters to a user is the error of long predictions, from windows all along the logs, of position and attitude as a
product, so that no unit counts more than another. The order is found from behind: of all findings, the one without
which the others predict best is the last, and so on; all keep their values, because one that is fitted without another
borrows what that does (drag is huge where wind is forbidden). Trim, which the next run has anew, comes behind what
lasts, and what no prediction needs comes last of all; meanwhile they stay in.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from sym2real.diagnosis.data.segments import WARM_UP
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import finite_errors, free_run_seconds, judged
from sym2real.diagnosis.errors.rungs import windows_of
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection, parameter_set
from sym2real.effects.trim import is_trim

LEAST = 1e-9

Score = Callable[[Sequence[Candidate]], float]


def by_importance(selection: Selection) -> list[tuple[Candidate, Fit]]:
    """Chosen effects, the most important first, each with the fit of all so far."""
    if selection.order is None:
        order, values, ordered = _order(selection), selection.origin, list[tuple[Candidate, Fit]]()
        for number, candidate in enumerate(order[:-1], start=1):
            values = candidate.copied(selection.fit.values, into=values)
            (fit,) = selection.problems.fit([Hypothesis(selection.free(order[:number]), values)])
            ordered.append((candidate, fit))
            values = fit.values
        selection.order = [*ordered, *((last, selection.fit) for last in order[-1:])]
    return selection.order


def _order(selection: Selection) -> list[Candidate]:
    if len(selection.chosen) < 2:
        return list(selection.chosen)
    score = partial(_score, selection, _windows(selection))
    needed = [candidate for candidate in selection.chosen if candidate not in selection.small]
    trim = [candidate for candidate in needed if _is_trim(selection, candidate)]
    lasting = [candidate for candidate in needed if candidate not in trim]
    kinds = (lasting, trim, selection.small)
    return [candidate for kind in kinds for candidate in _from_behind(score, kind, selection.chosen)]


def _from_behind(score: Score, some: Sequence[Candidate], chosen: Sequence[Candidate]) -> list[Candidate]:
    """Some of the chosen effects by importance, while the others stay."""
    rest, last = list(some), list[Candidate]()
    while len(rest) > 1:
        scores = [score([kept for kept in chosen if kept not in (own, *last)]) for own in rest]
        last.append(rest.pop(scores.index(min(scores))))
    return [*rest, *reversed(last)]


def _is_trim(selection: Selection, candidate: Candidate) -> bool:
    problem = selection.problems.problem
    slots, fitted = problem.library.slots, parameter_set(selection, [candidate], selection.fit.values)
    values = {slots[i].parameter.name: float(fitted[i]) for i in candidate.slots}
    return is_trim(problem.library.effects[candidate.name], values, problem.data)


def _windows(selection: Selection) -> Problem:
    """The logs in windows as long as a free run, or as the longest log allows."""
    problem = selection.problems.problem
    longest = max(len(trajectory) for trajectory in problem.data) - ROWS - WARM_UP - 1
    steps = min(round(free_run_seconds(problem.data.layouts.state) / problem.data.dt), longest)
    return Problem(problem.library, problem.data, windows_of(problem.data, steps))


def _score(selection: Selection, windows: Problem, kept: Sequence[Candidate]) -> float:
    """Sum of the logarithms of the errors at the windows' end with some effects at their values among all."""
    predicted = windows.states(parameter_set(selection, kept, selection.fit.values)[None])[0, :, -1]
    errors = finite_errors(windows.segments.layout, predicted, windows.segments.measured[:, -1])
    return float(np.log(np.maximum([np.square(errors[name]).mean() for name in judged(errors)], LEAST)).sum())
