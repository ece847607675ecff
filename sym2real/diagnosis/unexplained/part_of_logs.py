"""Effects in a part of the logs that explain more than what was found everywhere.

A load that is picked up in flight looks like a battery that empties, one that hung in half of the logs like another
thrust curve. So in the place of every effect that was found each effect is tried in a part of the segments alone, where
nothing depends on it elsewhere: from a moment of every log on, or until then, or in some of the logs. Chow's test has
one moment, known beforehand; of many the best is taken here, and the chance is shared among them: D. Andrews, "Tests
for parameter instability and structural change with unknown change point", Econometrica 61 (1993).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.estimate.fit import STEPS, Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.estimate.significance import standard_error
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.search.select import EffectSet, Selection, parameter_set
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.features import part_of_changes
from sym2real.diagnosis.unexplained.leftover import Leftover
from sym2real.effects.kind import with_unit

# Moments, evenly over the segments, from which on, or until which, an effect is tried.
MOMENTS = 24


@dataclass(frozen=True, eq=False)
class Part:
    """An effect in a part of the segments, beside others.

    Args:
        candidate: the effect.
        words: which part, for a sentence.
        inside: the part ``# (S,)``.
        loss: whitened squares of folds that the fit left out, by the quadratic model.
    """

    candidate: Candidate
    words: str
    inside: Tensor
    loss: float


def find_part(selection: Selection) -> tuple[Leftover, ...]:
    """What explains more in a part of the logs than an effect that was found, in its place; the surest for each."""
    return tuple(filter(None, (_instead_of(selection, own) for own in selection.chosen)))


def _instead_of(selection: Selection, own: Candidate) -> Leftover | None:
    problems, rest = selection.problems, selection.without(selection.present, own)
    parts = list(_parts(selection, rest, own))
    best = min(parts, key=lambda part: part.loss, default=None)
    if best is None:
        return None
    fit = _fitted(selection, selection.free([*rest.chosen, best.candidate]), rest.fit.values, best)
    gains = problems.held_out_segments(selection.fit) - problems.held_out_segments(fit)
    gain, saved = float(gains.sum()), rest.loss - selection.present.loss
    times = stats.t.isf(SETTINGS.false_alarms_of_each(len(parts)), problems.block_count - 1)
    if gain <= max(SETTINGS.worth_saying * saved, times * standard_error(problems, gains)):
        return None
    channel, instead = map(problems.library.key, (own.name, best.candidate.name))
    share, words = gain / (gain + saved), f"{_values(selection, fit, best.candidate)} there, none elsewhere"
    return Leftover(best.words, channel, share, words, motion=_moved(selection, fit, best), instead=instead)


def _moved(selection: Selection, fit: Fit, part: Part) -> float:
    """Part of the robot's motion that its model and what was found differ by."""
    problem = selection.problems.problem
    sets = fit.values, part.candidate.copied(selection.origin, into=fit.values), selection.fit.values
    there, elsewhere, present = problem.residuals(torch.stack(sets))
    return part_of_changes(problem.segments, torch.where(part.inside[:, None], there, elsewhere) - present)


def _values(selection: Selection, fit: Fit, candidate: Candidate) -> str:
    reported = parameter_set(selection, [candidate], fit.values)
    known = ((selection.problems.library.slots[slot].parameter, float(reported[slot])) for slot in candidate.slots)
    return ", ".join(f"{parameter.name} {with_unit(value, parameter.unit)}" for parameter, value in known)


def _parts(selection: Selection, rest: EffectSet, own: Candidate) -> Iterator[Part]:
    """Every effect that changes something at its null, in every part; the same in other logs is what differs by log."""
    problems, before = selection.problems, selection.free(rest.chosen)
    smooth = [other for other in selection.open(rest.chosen, selection.candidates) if not other.needs_start]
    whole = tuple(dict.fromkeys((*before, *(slot for candidate in smooth for slot in candidate.free))))
    (model,) = problems.quadratics([Hypothesis(whole, rest.fit.values)])
    moments = list(_moments(problems))
    for candidate in smooth:
        fit = model.part((*before, *candidate.free))
        by_log = () if candidate is own else _some_logs(problems, fit, candidate)
        for words, inside in (*moments, *by_log):
            loss = float(problems.left_out(problems.by_fold(_in_part(fit, candidate, inside))).sum())
            yield Part(candidate, words, inside, loss)


def _moments(problems: Problems) -> Iterator[tuple[str, Tensor]]:
    segments, logs = problems.problem.segments, problems.data
    times = np.array([logs[log].time[row] for log, row in zip(segments.log, segments.row, strict=True)])
    for moment in np.unique(np.quantile(times, np.arange(2, MOMENTS - 1) / MOMENTS, method="nearest")):
        after = torch.as_tensor(times >= moment)
        yield from ((f"after about {moment:.1f} s", after), (f"before about {moment:.1f} s", ~after))


def _some_logs(problems: Problems, fit: Fit, candidate: Candidate) -> Iterator[tuple[str, Tensor]]:
    """Two logs or more, by what each says of one of the effect's parameters alone: those with more, or with less."""
    if problems.log_count < SETTINGS.fewest_logs:
        return
    names = [problems.data[log].name for log in np.unique(problems.problem.segments.log)]
    for place in fit.places(candidate.free):
        parts = fit.gradient[:, place], fit.curvature[:, place, place]
        gradient, curvature = (summed(part, problems.logs) for part in parts)
        ordered = np.argsort((-gradient / curvature.clamp_min(1e-300)).numpy(), kind="stable")
        for count in range(2, len(ordered) - 1):
            for some in (ordered[:count], ordered[count:]):
                inside = torch.as_tensor(np.isin(problems.logs, some))
                yield f"in {', '.join(names[log] for log in sorted(some))} alone", inside


def _in_part(fit: Fit, candidate: Candidate, inside: Tensor) -> Fit:
    """The same where segments elsewhere do not depend on an effect."""
    there = torch.ones_like(fit.gradient)
    there[:, fit.places(candidate.free)] = inside[:, None].to(there)
    return replace(fit, gradient=fit.gradient * there, curvature=fit.curvature * there[:, :, None] * there[:, None, :])


def _fitted(selection: Selection, free: Free, values: Tensor, part: Part) -> Fit:
    """The joint fit with an effect in its part, by Gauss–Newton steps as long as they help."""
    problems, fit = selection.problems, _about(selection, free, values, part)
    for _ in range(STEPS):
        further = _about(selection, free, problems.moved(fit, problems.best_step(fit)), part)
        if further.total >= fit.total:
            break
        fit = further
    return fit


def _about(selection: Selection, free: Free, values: Tensor, part: Part) -> Fit:
    # Elsewhere the effect is what calibration says of the base.
    sets = values, part.candidate.copied(selection.origin, into=values)
    there, elsewhere = selection.problems.quadratics([Hypothesis(free, own) for own in sets])
    return _in_part(there.mixed(part.inside, elsewhere), part.candidate, part.inside)
