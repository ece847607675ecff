"""Which of the chosen effects are announced: those that predictions need, and those that whole logs establish.

Beside an effect whose form is a little wrong another one can be beyond chance that is not there. So each must be
needed: without it, the others fitted again, some error of logs that the fit left out must be larger than with it,
beyond its interval; or by a tenth, beyond that of the ratio of both.

An effect can be there and too small to matter beside what noise and disturbances make of a prediction: an arm of four
centimetres under the noise of a localisation. As predictions do not bear it out, whole logs must tell it from trim,
which differs from run to run, as surely as blocks tell a finding from chance, and no error may be larger with it. What
is needed least is dropped first, because what stands for it may be needed then. What commands between the rows may have
made of a factor stays, and is no answer: without it what they did would be taken for a disturbance.

A robot that is held where it would not stay (a pole upright, an arm) moves little, and what its start is off by grows:
predictions of the right model may be worse than that nothing changes, and worse than those of a wrong model of which it
grows more slowly. Where no model beats "hold", predictions judge nothing, and whole logs do.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import accumulate, takewhile

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.data.windows import JUDGED_AT, free_run_seconds, judged
from sym2real.diagnosis.errors.rungs import HeldOut, Rung, RungError
from sym2real.diagnosis.estimate.fit import Fit, Problems
from sym2real.diagnosis.estimate.significance import beyond_trim
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.search.intervals import attenuated
from sym2real.diagnosis.search.select import EffectSet, Selection, parameter_set
from sym2real.diagnosis.settings import SETTINGS

# Where the part of a single log begins that is predicted by the fit of the rest.
LAST_THIRD = 2 / 3


@dataclass(frozen=True)
class Predicted:
    """Logs, each predicted by the fit of the others.

    Args:
        selection: what was chosen.
        library: effects in the equations that predict.
        logs: of the fit.
    """

    selection: Selection
    library: Library
    logs: Dataset

    @cached_property
    def held_out(self) -> HeldOut:
        """The same as they are scored."""
        return left_out(self.selection, self.library, self.logs)

    @cached_property
    def horizons(self) -> tuple[float, ...]:
        """At which findings are judged, s; none where logs are too short."""
        return judged_horizons(self.held_out)

    def without_each(self) -> tuple[Rung, list[Rung]]:
        """Errors with all that was chosen, and without each of it."""
        selection, present = self.selection, self.selection.present
        whole, *others = self._by([present, *(selection.without(present, member) for member in present.chosen)])
        return whole, others

    def small(self) -> tuple[Candidate, ...]:
        """Effects without which no error that is judged is larger by a tenth, as many as may be left out together.

        Of two that stand for each other neither is missed alone.
        """
        if not (self.horizons and self.selection.chosen):
            return ()
        whole, others = self.without_each()
        falls = zip(map(partial(_rise_without, whole), others), self.selection.chosen, strict=True)
        alone = [pair for pair in sorted(falls, key=lambda pair: pair[0]) if pair[0] < SETTINGS.worth_saying]
        small = tuple(candidate for _, candidate in alone)
        sets = [*accumulate(small, self.selection.without, initial=self.selection.present)][1:]
        together = map(partial(_rise_without, whole), self._by(sets) if sets else [])
        return small[: sum(1 for _ in takewhile(lambda part: part < SETTINGS.worth_saying, together))]

    def bears_out(self, larger: EffectSet) -> bool:
        """Whether an error that is judged is surely a tenth larger without one effect more, or whole logs establish it,
        and no error is larger with it.

        Logs that are too short to predict bear out whatever was chosen.
        """
        if not self.horizons:
            return True
        whole, other = self._by([larger, self.selection.present])
        rises = _by_channel(whole, other, _rise)
        surely = max(rises[name] for name in judged(rises)) > 1.0 + SETTINGS.worth_saying
        return no_worse(whole, other) and (surely or self.established(larger.fit, larger.candidate))

    def no_worse(self, effects: EffectSet, other: EffectSet) -> bool:
        """Whether no error is larger by a set beyond chance than by another one, as far as logs predict."""
        return not self.horizons or no_worse(*self._by([effects, other]))

    def established(self, fit: Fit, candidate: Candidate) -> bool:
        """Whether whole logs tell an effect of a fit from trim."""
        return beyond_trim(self.selection.problems, fit, candidate, self.selection.origin, self.selection.tested)

    def needs_most(self, larger: Sequence[EffectSet]) -> EffectSet | None:
        """Of sets with one effect more than was chosen, that whose one predictions need most; None if none."""
        if not (larger and self.horizons):
            return None
        without, *others = self._by([self.selection.present, *larger])
        rises = [largest_rise(other, without) for other in others]
        return larger[int(np.argmax(rises))] if max(rises) > 1.0 else None

    def _by(self, sets: Sequence[EffectSet]) -> tuple[Rung, ...]:
        stages = [("", left_out_sets(self.selection, effects.chosen, effects.fit)) for effects in sets]
        return self.held_out.ladder(stages, self.horizons)


def keep_needed(predicted: Predicted) -> tuple[Candidate, ...]:
    """Drop effects until predictions need, or whole logs establish, all of them; those that were dropped."""
    selection, before = predicted.selection, predicted.selection.chosen
    while predicted.horizons and selection.chosen:
        whole, others = predicted.without_each()
        rises = {
            place: rise
            for place, (candidate, other) in enumerate(zip(selection.chosen, others, strict=True))
            if (rise := largest_rise(whole, other)) <= 1.0
            and not (predicted.established(selection.fit, candidate) and no_worse(whole, other))
            and not attenuated(selection, candidate, selection.fit)
        }
        if not rises:
            break
        fewer = selection.without(selection.present, selection.chosen[min(rises, key=rises.__getitem__)])
        selection.put(fewer.chosen, fewer.fit)
    return tuple(candidate for candidate in before if candidate not in selection.chosen)


def _rise_without(whole: Rung, without: Rung) -> float:
    """The largest part of a judged error that goes with what is left out; all of it where predictions judge none."""
    if not (whole.beats_hold or without.beats_hold):
        return 1.0
    parts = _by_channel(whole, without, lambda error, other: 1.0 - error.value / max(other.value, 1e-12))
    return max(parts[name] for name in judged(parts))


def no_worse(whole: Rung, without: Rung) -> bool:
    """Whether no error is larger beyond chance than without an effect, where predictions judge at all."""
    return largest_rise(without, whole) <= 1.0 or not (whole.beats_hold or without.beats_hold)


def largest_rise(whole: Rung, without: Rung) -> float:
    """Factor by which an error rises without an effect beyond chance; the largest of all errors."""
    return max(_by_channel(whole, without, _rise).values())


def _by_channel(whole: Rung, without: Rung, of: Callable[[RungError, RungError], float]) -> dict[str, float]:
    """What an error with an effect and the one without it say together, by channel: the largest over the horizons."""
    pairs = [(errors, without.horizons[horizon]) for horizon, errors in whole.horizons.items()]
    return {name: max(of(errors[name], others[name]) for errors, others in pairs) for name in pairs[0][0]}


def _rise(whole: RungError, without: RungError) -> float:
    """The lower end of an error's own interval over that error with the effect; where a tenth of it goes with the
    effect, also the lower end of their ratio, which is known better: where a robot is hard to predict, both are large.
    """
    rise = without.low / max(whole.value, 1e-12)
    little = whole.value > (1 - SETTINGS.worth_saying) * without.value
    return rise if little else max(rise, without.ratio_to(whole)[0])


def judged_horizons(held: HeldOut) -> tuple[float, ...]:
    """Horizons (s) at which findings are judged: a controller's and a free run's; none where logs are too short."""
    wanted = held.horizons(free_run_seconds(held.logs.layouts.state))
    return tuple(sorted({min(wanted, key=lambda horizon: abs(horizon - JUDGED_AT)), wanted[-1]})) if wanted else ()


def left_out(selection: Selection, library: Library, logs: Dataset) -> HeldOut:
    """The logs of a search, each by the fit of the others; the last third of a single log by that of the rest."""
    return HeldOut(library, logs, fold_of_log(selection), LAST_THIRD if selection.problems.log_count == 1 else 0.0)


def left_out_sets(selection: Selection, chosen: Sequence[Candidate], fit: Fit) -> Tensor:
    """Parameter sets of a model with some effects ``# (folds, P)``, by fits that took no part in what is predicted.

    A log is predicted by the fit of the others; the last third of a single log by that of the rest.
    """
    return torch.stack([parameter_set(selection, chosen, values) for values in by_others(selection, fit)])


def by_others(selection: Selection, fit: Fit, problems: Problems | None = None) -> list[Tensor]:
    """Of every fold the parameter set ``# (P,)`` that all segments but its own ask for, as far as there are any.

    Args:
        selection: whose logs make the folds.
        fit: to all segments.
        problems: of the fit; by default those of the search.
    """
    problems = problems or selection.problems
    still = fit.gradient.new_zeros(len(fit.whole))
    parts = parts_of_others(selection, problems.problem.segments)
    steps = [problems.sure_step(fit.of_segments(part), fit) if part.any() else still for part in parts]
    return [problems.moved(fit, step) for step in steps]


def parts_of_others(selection: Selection, segments: Segments) -> list[Tensor]:
    """Of every fold the segments ``# (S,)`` that are not its own; of a single log those of the first two thirds."""
    if selection.problems.log_count == 1:
        rows = np.array([len(log) for log in selection.problems.problem.data])
        return [torch.as_tensor(segments.row + segments.length <= LAST_THIRD * rows[segments.log])]
    folds = fold_of_log(selection)
    return [torch.as_tensor(folds[segments.log] != fold) for fold in np.unique(folds)]


def fold_of_log(selection: Selection) -> NDArray[np.int64]:
    """Fold of every log: its place among those that have segments; a log without any has that of the one before it."""
    problem = selection.problems.problem
    places = np.searchsorted(np.unique(problem.segments.log), np.arange(len(problem.data)), side="right") - 1
    return np.maximum(places, 0)
