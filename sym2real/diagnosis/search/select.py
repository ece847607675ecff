"""Which effects are there: greedy additions, then every addition must hold against dropping and against its rivals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from torch import Tensor

from sym2real.diagnosis.estimate.fit import REFIT_STEPS, Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.estimate.significance import beyond_chance
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.stages import OnProgress

# What a finding needs beside significance: a relative fall of the held-out loss. Null data show falls of 0.2 % at most;
# beside another finding, whose form may be a little wrong, more is asked for.
GAIN, GAIN_BESIDE = 0.01, 0.03
MOST_FINDINGS = 8
# Candidates that are refitted in full after screening: at most so many, none that saves less than this part of what
# the best one does, or of the gain that a finding needs.
REFITTED = 6
PROMISING, HOPELESS = 0.25, 0.3
# In units of a parameter's scale: nearer to a bound a value is at it.
AT_BOUND = 1e-6


@dataclass(frozen=True, eq=False)
class Scored:
    """A candidate joined to what was chosen before, fitted.

    Args:
        candidate: what was added.
        fit: of all chosen and this.
        held_out: loss per fold ``# (folds,)``.
    """

    candidate: Candidate
    fit: Fit
    held_out: Tensor

    @property
    def loss(self) -> float:
        """Held-out loss of all folds."""
        return float(self.held_out.sum())


@dataclass(eq=False)
class Selection:
    """The state of a search.

    Args:
        problems: data, whitening, folds.
        candidates: what competes.
        origin: parameter set without effects (null, or what calibration says of the base) ``# (P,)``.
        chosen: what is in, in order.
        fit: of what is in.
        held_out: its loss per fold.
        tried: number of hypotheses that had a chance.
        on_progress: told what has been found so far.
        order: what is in by importance, once somebody has asked.
    """

    problems: Problems
    candidates: Sequence[Candidate]
    origin: Tensor
    chosen: list[Candidate] = field(default_factory=list)
    fit: Fit = None  # type: ignore[assignment]  # set by __post_init__
    held_out: Tensor = None  # type: ignore[assignment]
    tried: int = 0
    on_progress: OnProgress = lambda _: None
    order: list[tuple[Candidate, Fit]] | None = None
    _rankings: dict[tuple[str, ...], list[Scored]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tried = len(self.candidates)
        self.put([], self.problems.fit([Hypothesis((), self.origin)], REFIT_STEPS)[0])

    def put(self, chosen: Sequence[Candidate], fit: Fit) -> None:
        """Make this the present state."""
        self.chosen, self.fit, self.order = list(chosen), fit, None
        self.held_out = self.problems.held_out(fit)

    @property
    def loss(self) -> float:
        """Held-out loss of the present state, all folds."""
        return float(self.held_out.sum())

    def free(self, chosen: Sequence[Candidate]) -> Free:
        """Parameters of several candidates, in their order."""
        return tuple(tied for one in chosen for tied in one.free)

    def places(self, chosen: Sequence[Candidate], one: Candidate) -> list[int]:
        """Where a candidate's parameters stand among those of all chosen."""
        free = self.free(chosen)
        return [free.index(tied) for tied in one.free]

    def ranked(
        self, chosen: Sequence[Candidate], values: Tensor, rivals: Sequence[Candidate] | None = None
    ) -> list[Scored]:
        """Others, each joined to what is chosen, best first: screened on quadratic models, the best refitted.

        Args:
            chosen: what is in.
            values: parameter set of its fit.
            rivals: what is joined to it, whether it is promising or not; by default every candidate that is.
        """
        names = tuple(sorted(one.name for one in chosen))
        if rivals is not None:
            screened = self._screened(chosen, values, self.open(chosen, rivals))[1]
            return self.refitted(chosen, [(one, start) for _, one, start in screened[:REFITTED]])
        if names not in self._rankings:
            promising = self._promising(chosen, values, self.open(chosen, self.candidates))
            self._rankings[names] = self.refitted(chosen, promising)
        return self._rankings[names]

    def open(self, chosen: Sequence[Candidate], rivals: Sequence[Candidate]) -> list[Candidate]:
        """Those of the rivals that share no parameter with what is chosen."""
        taken = {slot for one in chosen for slot in one.slots}
        shut = {name for one in chosen for name in one.excludes}
        return [one for one in rivals if one.name not in shut and taken.isdisjoint(one.slots)]

    def refitted(self, chosen: Sequence[Candidate], started: Sequence[tuple[Candidate, Tensor]]) -> list[Scored]:
        """Candidates, each fitted jointly with what is chosen from a parameter set, best first."""
        fits = self.problems.fit([Hypothesis(self.free([*chosen, one]), start) for one, start in started], REFIT_STEPS)
        found = [Scored(one, fit, self.problems.held_out(fit)) for (one, _), fit in zip(started, fits, strict=True)]
        return sorted(found, key=lambda scored: scored.loss)

    def _promising(
        self, chosen: Sequence[Candidate], values: Tensor, rivals: Sequence[Candidate]
    ) -> list[tuple[Candidate, Tensor]]:
        """Rivals that are worth a refit, each with the parameter set at which it starts."""
        reference, screened = self._screened(chosen, values, rivals)
        if not screened:
            return []
        least = max(PROMISING * (reference - screened[0][0]), HOPELESS * GAIN * reference)
        return [(one, start) for loss, one, start in screened[:REFITTED] if reference - loss >= least]

    def _screened(
        self, chosen: Sequence[Candidate], values: Tensor, rivals: Sequence[Candidate]
    ) -> tuple[float, list[tuple[float, Candidate, Tensor]]]:
        """Held-out loss without any rival, and rivals by the one that is predicted with them, each with its start."""
        before = self.free(chosen)
        at_null = [one for one in rivals if not one.needs_start]
        whole = tuple(dict.fromkeys((*before, *(tied for one in at_null for tied in one.free))))
        everything = self.problems.quadratics([Hypothesis(whole, values)])[0]
        places = {tied: place for place, tied in enumerate(everything.whole)}
        reference = float(self.problems.held_out(everything.part([places[tied] for tied in before])).sum())
        parts = [(one, everything.part([places[tied] for tied in (*before, *one.free)])) for one in at_null]
        started = [(one, level) for one in rivals for level in one.starts]
        hypotheses = []
        for one, level in started:
            moved = values.clone()
            moved[list(one.free[0])] = level
            hypotheses.append(Hypothesis((*before, *one.free), moved))
        fits = self.problems.quadratics(hypotheses)
        parts += [(one, fit) for (one, _), fit in zip(started, fits, strict=True)]
        best: dict[str, tuple[float, Candidate, Tensor]] = {}
        for one, fit in parts:
            loss = float(self.problems.held_out(fit).sum())
            if one.name not in best or loss < best[one.name][0]:
                best[one.name] = (loss, one, self.problems.moved(fit, self.problems.best_step(fit)))
        return reference, sorted(best.values(), key=lambda entry: entry[0])

    def gain(self, scored: Scored) -> float:
        """Relative fall of the held-out loss against the present state."""
        return 1.0 - scored.loss / self.loss

    def significant(self, fit: Fit, one: Candidate) -> bool:
        """Whether a candidate's parameters differ from none beyond chance, inside their bounds."""
        return not self.at_bound(fit, one) and beyond_chance(self.problems, fit, one, self.origin, self.tried)

    def at_bound(self, fit: Fit, one: Candidate) -> bool:
        """Whether a fit has driven a parameter to the end of what is likely, which is not where the effect is none."""
        library = self.problems.problem.library
        slots = [tied[0] for tied in one.free]
        values, near = fit.values[slots], AT_BOUND * library.scale[slots]
        ends = [(values - bound[slots]).abs() <= near for bound in library.bounds]
        elsewhere = (values - library.null[slots]).abs() > near
        return bool(((ends[0] | ends[1]) & elsewhere).any())

    def grow(self) -> None:
        """Add the best candidate while it is worth it."""
        while len(self.chosen) < MOST_FINDINGS:
            for scored in self.ranked(self.chosen, self.fit.values):
                if self.gain(scored) <= (GAIN_BESIDE if self.chosen else GAIN):
                    return
                chosen = [*self.chosen, scored.candidate]
                if self.significant(scored.fit, scored.candidate):
                    self.put(chosen, scored.fit)
                    self.on_progress(f"found so far: {', '.join(one.name for one in chosen)}; searching on")
                    break
            else:
                return

    def without(self, one: Candidate) -> tuple[list[Candidate], Fit]:
        """The fit of all chosen but one."""
        rest = [other for other in self.chosen if other is not one]
        values = self.fit.values.clone()
        values[one.slots] = self.origin[one.slots]
        return rest, self.problems.fit([Hypothesis(self.free(rest), values)], REFIT_STEPS)[0]

    def prune(self) -> None:
        """Drop what is not worth its place beside the others."""
        for one in list(self.chosen):
            if len(self.chosen) < 2:
                return
            rest, fit = self.without(one)
            kept = 1.0 - self.loss / float(self.problems.held_out(fit).sum())
            if kept <= GAIN_BESIDE or not self.significant(self.fit, one):
                self.put(rest, fit)

    def restart(self) -> bool:
        """Fit what is in from its other starts too: a delay's error has a kink at every whole step that stops fits.

        Returns:
            Whether one of them led to a better fit, which held-out data bear out.
        """
        hypotheses = []
        for tied, level in ((one.free[0], level) for one in self.chosen for level in one.starts):
            values = self.fit.values.clone()
            values[list(tied)] = level
            hypotheses.append(Hypothesis(self.free(self.chosen), values))
        fits = self.problems.fit(hypotheses, REFIT_STEPS) if hypotheses else []
        best = min((self.fit, *fits), key=lambda fit: fit.total)
        better = best is not self.fit and float(self.problems.held_out(best).sum()) < self.loss
        if better:
            self.put(self.chosen, best)
        return better

    def swap(self) -> None:
        """Exchange what a rival explains better."""
        for one in list(self.chosen):
            rest, fit = self.without(one)
            ranking = [scored for scored in self.ranked(rest, fit.values) if scored.candidate is not one]
            if ranking and ranking[0].loss < self.loss * (1 - 0.002):
                best = ranking[0]
                if self.significant(best.fit, best.candidate):
                    self.put([*rest, best.candidate], best.fit)
