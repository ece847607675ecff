"""Sets of effects that explain logs together, and the present set of a search: what joins it, what is left of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import torch
from torch import Tensor

from sym2real.diagnosis.estimate.fit import Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.estimate.ripple import slowest_count
from sym2real.diagnosis.estimate.significance import beyond_chance, half_widths, standard_error
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import Parameter

# Candidates that are refitted in full after screening: at most so many, none that is to save less than this part of the
# gain that a finding needs. The quadratic model may be wrong by as much.
REFITTED, PROMISING = 6, 0.3
# Held-out loss of a set, and per effect beside it the loss that is promised, with its start.
Screening = tuple[float, list[tuple[float, Candidate, Tensor]]]
# Relative fall of the whitened squares by which a fit of the same set is another one.
BETTER = 1e-4
# In units of a parameter's scale: nearer to a bound a value is at it.
AT_BOUND = 1e-6


@dataclass(frozen=True, eq=False)
class EffectSet:
    """Effects and their joint fit.

    Args:
        chosen: the effects, in the order in which they came in.
        fit: of all.
        held_out: loss per fold ``# (folds,)``.
        price: the loss of all folds with the effects' charges.
    """

    chosen: tuple[Candidate, ...]
    fit: Fit
    held_out: Tensor
    price: float

    @property
    def candidate(self) -> Candidate:
        """The effect that came in last."""
        return self.chosen[-1]

    @cached_property
    def loss(self) -> float:
        """Held-out loss of all folds."""
        return float(self.held_out.sum())

    @cached_property
    def names(self) -> frozenset[str]:
        """Of the effects."""
        return frozenset(candidate.name for candidate in self.chosen)

    @property
    def smaller(self) -> list[frozenset[str]]:
        """Names of the sets with one effect less."""
        return [self.names - {name} for name in self.names]


@dataclass(eq=False)
class Selection:
    """The state of a search.

    Args:
        problems: data, whitening, folds.
        candidates: what competes.
        origin: parameter set without effects (null, or what calibration says of the base) ``# (P,)``.
        tested: number of hypotheses that had a chance.
        present: what is in, in order, with its fit.
        small: of what is in, effects without which no error that is judged is larger by a tenth, once that is known.
        order: what is in by importance, once somebody has asked.
        known: every set that was fitted, by its best fit.
    """

    problems: Problems
    candidates: Sequence[Candidate]
    origin: Tensor
    tested: int = field(init=False)
    present: EffectSet = field(init=False)
    small: tuple[Candidate, ...] = ()
    order: list[tuple[Candidate, Fit]] | None = None
    known: dict[frozenset[str], EffectSet] = field(default_factory=dict)
    _larger: dict[frozenset[str], list[EffectSet]] = field(default_factory=dict)
    _screenings: dict[EffectSet, Screening] = field(default_factory=dict)
    _significant: dict[tuple[Fit, str], bool] = field(default_factory=dict)
    _models: dict[tuple[Free, bytes], Fit] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tested = len(self.candidates)
        self.put([], self.problems.fit([Hypothesis((), self.origin)])[0])

    def set_of(self, chosen: Sequence[Candidate], fit: Fit) -> EffectSet:
        """Effects, their joint fit, and its loss on what is left out; of a set that is known the better fit."""
        held_out = self.problems.held_out(fit)
        made = EffectSet(tuple(chosen), fit, held_out, self.price(float(held_out.sum()), len(chosen)))
        if (known := self.known.get(made.names, made)).fit.total < (1 - BETTER) * fit.total:
            return replace(known, chosen=made.chosen)
        self.known[made.names] = min(known, made, key=lambda effects: effects.fit.total)
        return made

    def price(self, loss: float, count: int) -> float:
        """What a set of effects costs: its held-out loss, dearer by what each of its effects must take off it.

        What is beside an effect whose form is a little wrong must save more, unless there are whole logs enough to tell
        it from trim (see ``needed.py``).
        """
        beside = SETTINGS.gain_beside if self.problems.log_count >= SETTINGS.fewest_logs else SETTINGS.gain_few
        return loss / ((1 - SETTINGS.gain) * (1 - beside) ** (count - 1)) if count else loss

    def put(self, chosen: Sequence[Candidate], fit: Fit) -> None:
        """Make this the present state."""
        self.present, self.small, self.order = self.set_of(chosen, fit), (), None

    @property
    def chosen(self) -> list[Candidate]:
        """What is in, in order."""
        return list(self.present.chosen)

    @property
    def fit(self) -> Fit:
        """Of what is in."""
        return self.present.fit

    def beside(self, chosen: Sequence[Candidate], fit: Fit) -> EffectSet:
        """Effects, fitted from the values that they have in another fit."""
        values, slots = self.origin.clone(), [*self.problems.nuisance, *(slot for own in chosen for slot in own.slots)]
        values[slots] = fit.values[slots]
        return self.set_of(chosen, self.problems.fit([Hypothesis(self.free(chosen), values)])[0])

    def free(self, chosen: Sequence[Candidate]) -> Free:
        """Parameters of several candidates, in their order."""
        return tuple(slot for candidate in chosen for slot in candidate.free)

    def ranked(self, effects: EffectSet, candidates: Sequence[Candidate]) -> list[EffectSet]:
        """A set with each candidate, promising or not, best first: screened on quadratic models, the best refitted."""
        screened = self._screened(effects, candidates)[1]
        return self.refitted(effects.chosen, [(candidate, start) for _, candidate, start in screened[:REFITTED]])

    def larger(self, effects: EffectSet) -> list[EffectSet]:
        """A set with each of the effects that promise something beside it, best first."""
        if effects.names not in self._larger:
            reference, screened = self.screening(effects)
            most = (1 - PROMISING * SETTINGS.gain_of(len(effects.chosen) + 1)) * reference
            promising = [(candidate, start) for loss, candidate, start in screened[:REFITTED] if loss <= most]
            self._larger[effects.names] = self.refitted(effects.chosen, promising)
        return self._larger[effects.names]

    def forget(self, names: frozenset[str]) -> None:
        """Larger sets were fitted from a fit of these effects that has been replaced."""
        self._larger.pop(names, None)

    def promise(self, effects: EffectSet) -> float:
        """Price of a set with the effect that its sensitivity matrix promises most of; its own where none helps."""
        reference, screened = self.screening(effects)
        lowest = min([reference, *(loss for loss, _, _ in screened)])
        return min(effects.price, self.price(lowest, len(effects.chosen) + 1))

    def screening(self, effects: EffectSet) -> Screening:
        """What one effect more promises beside a set, the best first."""
        if effects not in self._screenings:
            self._screenings[effects] = self._screened(effects, self.candidates)
        return self._screenings[effects]

    def surely_cheaper(self, cheaper: EffectSet, other: EffectSet) -> bool:
        """Whether a set costs less than another by more than the standard error of how held-out losses differ."""
        gain = self.problems.held_out_segments(other.fit) - self.problems.held_out_segments(cheaper.fit)
        return other.price - cheaper.price > standard_error(self.problems, gain)

    def complexity(self, effects: EffectSet) -> tuple[int, int]:
        """Number of effects that do nothing on one side of a threshold; of parameters that differ from none.

        Few blocks do not tell which do, and a share that goes with another parameter is no number of its own.
        """
        fit, slots, library = effects.fit, list(effects.fit.free), self.problems.library
        away = ((fit.values - self.origin) / library.scale)[slots].abs()
        there = (away > half_widths(self.problems, fit)[: len(slots)]) & self.problems.identifiable(fit)[: len(slots)]
        own = torch.tensor([library.slots[slot].parameter.acts_alone for slot in slots], dtype=torch.bool)
        enough = self.problems.block_count >= SETTINGS.fewest_pieces
        return sum(own.needs_start for own in effects.chosen), enough * int((there & own).sum())

    def open(self, chosen: Sequence[Candidate], others: Sequence[Candidate]) -> list[Candidate]:
        """Those of the candidates that share no parameter with what is chosen."""
        taken = {slot for candidate in chosen for slot in candidate.slots}
        shut = {name for candidate in chosen for name in candidate.excludes}
        return [candidate for candidate in others if candidate.name not in shut and taken.isdisjoint(candidate.slots)]

    def refitted(self, chosen: Sequence[Candidate], started: Sequence[tuple[Candidate, Tensor]]) -> list[EffectSet]:
        """Candidates, each fitted jointly with what is chosen from a parameter set, best first."""
        fits = self.problems.fit([Hypothesis(self.free([*chosen, own]), start) for own, start in started])
        joined = [self.set_of([*chosen, candidate], fit) for (candidate, _), fit in zip(started, fits, strict=True)]
        return sorted(joined, key=lambda scored: scored.loss)

    def fitted_anew(self, effects: EffectSet) -> list[EffectSet]:
        """The same effects, fitted from the other starts of each: a set may have several valleys."""
        hypotheses = self.started(effects.chosen, effects.fit.values)
        return [self.set_of(effects.chosen, fit) for fit in self.problems.fit(hypotheses)]

    def started(self, chosen: Sequence[Candidate], values: Tensor) -> list[Hypothesis]:
        """Effects from values ``# (P,)`` of which one is at another of its starts."""
        free = self.free(chosen)
        return [Hypothesis(free, own.started(values, start)) for own in chosen for start in own.starts]

    def _screened(self, effects: EffectSet, others: Sequence[Candidate]) -> Screening:
        """Held-out loss without any candidate, and candidates by the loss predicted with them, each with its start."""
        before, values, others = self.free(effects.chosen), effects.fit.values, self.open(effects.chosen, others)
        at_null = [candidate for candidate in others if not candidate.needs_start]
        everything = self.model_of_all(before, values, at_null)
        reference = float(self.problems.left_out(everything.part(before)).sum())
        parts = [(candidate, everything.part((*before, *candidate.free))) for candidate in at_null]
        started = [(candidate, level) for candidate in others for level in candidate.starts]
        fits = self.problems.beside(before, values, [(own.free, own.started(values, level)) for own, level in started])
        parts += [(candidate, self.problems.by_fold(fit)) for (candidate, _), fit in zip(started, fits, strict=True)]
        best: dict[str, tuple[float, Candidate, Tensor]] = {}
        losses = [float(self.problems.left_out(fit).sum()) for _, fit in parts]
        for loss, (candidate, fit) in sorted(zip(losses, parts, strict=True), key=lambda entry: entry[0]):
            if candidate.name not in best:
                best[candidate.name] = (loss, candidate, self.problems.moved(fit, self.problems.best_step(fit)))
        return reference, [*best.values()]

    def model_of_all(self, before: Free, values: Tensor, candidates: Sequence[Candidate]) -> Fit:
        """The quadratic model, by fold, of parameters that are free and of all candidates at their null."""
        whole = tuple(dict.fromkeys((*before, *(slot for candidate in candidates for slot in candidate.free))))
        asked = whole, values.numpy().tobytes()
        if asked not in self._models:
            (at_null,) = self.problems.quadratics([Hypothesis(whole, values)])
            self._models[asked] = self.problems.by_fold(at_null)
        return self._models[asked]

    def significant(self, fit: Fit, candidate: Candidate) -> bool:
        """Whether a candidate's parameters differ from none beyond chance, inside their bounds."""
        asked = fit, candidate.name
        if asked not in self._significant:
            inside = not self.at_bound(fit, candidate)
            self._significant[asked] = inside and beyond_chance(self.problems, fit, candidate, self.origin, self.tested)
        return self._significant[asked]

    def holds(self, effects: EffectSet) -> bool:
        """Whether every effect of a set is beyond chance; those that need a start, and the longest test, come last."""
        members = sorted(effects.chosen, key=lambda member: member.needs_start)
        return all(self.significant(effects.fit, member) for member in members)

    def at_bound(self, fit: Fit, candidate: Candidate) -> bool:
        """Whether a fit has driven a parameter to the end of what is likely, which is not where the effect is none.

        A share that goes with another parameter ends where it must, at nothing and all. What repeats along a joint ends
        where too few of its periods are passed.
        """
        problem, library = self.problems.problem, self.problems.problem.library
        own, first = library.effects[library.slots[candidate.free[0]].effect], float(fit.values[candidate.free[0]])
        too_few = own.searching.repeats and first < slowest_count(problem.data, own.column)
        slots = [slot for slot in candidate.slots if library.slots[slot].parameter.acts_alone]
        values, near = fit.values[slots], AT_BOUND * library.scale[slots]
        low, high = ((values - bound[slots]).abs() <= near for bound in library.bounds)
        unlikely = torch.tensor([not library.slots[slot].parameter.low_is_likely for slot in slots], dtype=torch.bool)
        elsewhere = (values - library.null[slots]).abs() > near
        return too_few or bool(((low & unlikely | high) & elsewhere).any())

    def driven_to_bounds(self) -> list[str]:
        """Effects that would make the set surely cheaper, were they not at the end of what is likely."""
        cheaper = (other for other in self.larger(self.present) if self.surely_cheaper(other, self.present))
        return [other.candidate.name for other in cheaper if self.at_bound(other.fit, other.candidate)]

    def predicted_without(self, effects: EffectSet, candidate: Candidate) -> float:
        """Price of a set without one of its effects, by the quadratic model about the set's fit."""
        fit, slots = effects.fit, candidate.slots
        step = (self.origin[slots] - fit.values[slots]) / self.problems.library.scale[slots]
        loss = self.problems.left_out(self.problems.by_fold(fit).without(slots, step)).sum()
        return self.price(float(loss), len(effects.chosen) - 1)

    def without(self, effects: EffectSet, candidate: Candidate) -> EffectSet:
        """A set of effects but one, fitted from the fit of all of them."""
        return self.beside([other for other in effects.chosen if other is not candidate], effects.fit)


def reported(value: float, origin: float, parameter: Parameter) -> float:
    """A fitted value as a deviation from what calibration says of the base, counted from the null value.

    Of what cannot be less than nothing (a delay), less than the base's own is nothing. Where no end can be reached (an
    inertia that leaves none), the last value that is likely stands for what lies beyond.
    """
    if parameter.null == 0.0:
        nearest = parameter.domain.nearest(value - origin)
        return nearest if nearest in parameter.domain else parameter.low
    return value / origin if parameter.null == 1.0 and origin > 0 else value


def parameter_set(selection: Selection, chosen: Sequence[Candidate], values: Tensor) -> Tensor:
    """The library's parameter set of a model with some effects at their reported values, and nothing else."""
    library = selection.problems.problem.library
    result = library.null
    for slot in selection.free(chosen):
        result[slot] = reported(float(values[slot]), float(selection.origin[slot]), library.slots[slot].parameter)
    return result
