"""What comes before any search: the base's own faults, candidates, and the covariance of errors."""

from dataclasses import dataclass, field, replace

import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import cut
from sym2real.diagnosis.estimate.calibrate import Calibration, calibrated, lifted, refined
from sym2real.diagnosis.estimate.fit import Problems, nuisance_of
from sym2real.diagnosis.estimate.full_model import full_fit
from sym2real.diagnosis.estimate.ripple import find_counts
from sym2real.diagnosis.estimate.simulator import SWITCHED_OFF, flown_along, with_effects_of
from sym2real.diagnosis.estimate.swing import Swing, find_swing
from sym2real.diagnosis.estimate.whitening import Spread, Whitened, Whitening, estimate, free_start, with_wander
from sym2real.diagnosis.faults.sanity import Checked
from sym2real.diagnosis.predict.candidate import Candidate, Counts, at_first_count, candidates, library_for, not_tested
from sym2real.diagnosis.predict.competitors import NotTested
from sym2real.diagnosis.predict.instability import steady_length
from sym2real.diagnosis.predict.library import Library, library_of
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.question import Examined, Question
from sym2real.diagnosis.settings import SETTINGS
from sym2real.errors import ModelError
from sym2real.plants import MujocoPlant
from sym2real.robots.left_out import left_out_notes
from sym2real.symbolic import Equations
from sym2real.symbolic.mass_normalised import units_notes

PROMISING = 0.05  # chance below which a swing is worth another estimate of the disturbances

# Times that variances are estimated from a full model's residuals, each fit weighted by the last estimate.
ROUNDS = 3
# Part of every segment that the first full fit goes by.
FIRST = 0.25

CONTRADICTED = "the base's own errors in the plain simulator are left aside: these logs do not show them"
ADVICE = "check the units of its commands and its parameters"


@dataclass(frozen=True, eq=False)
class Refined:
    """A model whose constants fit whole pieces of what the plain simulator does.

    Args:
        examined: what was asked, and the checked data.
        model: the base without its command filters, which have acted on the data.
        library: its equations with every candidate in them.
        searched: the same with the refined base, on which hypotheses compete.
        plant: the plain simulator with the effects that the model has already, if there is one.
        flown: the logs' manoeuvres in it, where it can fly them.
        notes: remarks on data and method.
        length: rows of the segments.
        counts: where effects that repeat along a joint start.
    """

    examined: Examined
    model: Equations
    library: Library
    searched: Library
    plant: MujocoPlant | None
    flown: Dataset | None
    notes: tuple[str, ...]
    length: int
    counts: Counts = field(default_factory=dict, kw_only=True)


@dataclass(frozen=True, eq=False)
class Prepared(Refined):
    """A model against checked data, ready for hypotheses.

    Args:
        checked: the data, faults undone.
        scored: the logs that score what is found.
        candidates: what competes.
        problems: data, whitening, folds.
        full_fit: parameter set of all effects at once, which misses little ``# (P,)``.
        origin: parameter set from which effects are counted: null, or what calibration says of the base ``# (P,)``.
        calibration: the base against the plain simulator; None without one, and before it.
        swing: frequency and phases of a force that swings, if one was found.
        not_tested: effects that do not compete, and why.
    """

    checked: Checked
    scored: Dataset
    candidates: tuple[Candidate, ...]
    problems: Problems
    full_fit: torch.Tensor
    origin: torch.Tensor
    swing: Swing | None
    not_tested: tuple[NotTested, ...]
    calibration: Calibration | None = None

    @property
    def question(self) -> Question:
        """What was asked."""
        return self.examined.question

    @property
    def calibrated(self) -> bool:
        """Whether the plain simulator says that the base is off, in its constants or by effects."""
        return self.searched is not self.library or not torch.equal(self.origin, self.searched.null)

    @property
    def whitening(self) -> Whitening:
        """Noise and disturbances of the logs."""
        return self.problems.whitening


def refine_base(examined: Examined) -> Refined:
    """The logs' manoeuvres flown in the plain simulator, and the base's constants fitted to that."""
    question, checked, model = examined.question, examined.checked, examined.question.model
    plant, uncalibrated = with_effects_of(model, question.plant, checked.data.dt)
    flown = None
    if not question.calibrate:
        uncalibrated = SWITCHED_OFF
    elif plant is not None:
        flown, uncalibrated = flown_along(model, plant, checked.data)
    about_model = (*units_notes(model), *left_out_notes(model, checked.data), *filter(None, [uncalibrated]))
    model = replace(model, filters=()) if model.filters else model
    library = library_for(model, checked.data, question.exclude, question.include)
    base, searched = library.base if flown is None else refined(library, flown, checked.data), library
    if base is not library.base:
        form = library_of(lifted(library.base), tuple(dict.fromkeys(map(library.key, library.effects))))
        searched = form.at(**base.parameters)
    notes, length = (*checked.notes, *about_model), steady_length(searched, checked.data)
    return Refined(examined, model, library, searched, plant, flown, notes, length)


def estimate_covariance(base: Refined) -> Prepared:
    """Segments, noise and disturbances, and the phase of a force that swings."""
    data = base.examined.checked.data
    whitened = _whitened(base, base.searched, data)
    if base.searched is not base.library:
        base, whitened = _likelier(base, whitened)
    if counts := find_counts(whitened):
        base = replace(base, counts=counts)
        whitened = _whitened(base, base.searched, data)
    base = replace(base, notes=(*base.notes, *unpredicted_notes(whitened.problem)))
    searched = base.searched
    effects, last, logs = candidates(searched, data, counts), whitened, data
    swinging = [k for k, slot in enumerate(searched.slots) if searched.effects[slot.effect].searching.swings]
    # Disturbances are smaller without what swings, and against these it is held.
    for chance in (PROMISING, SETTINGS.false_alarms_of_each(len(effects))):
        still = last.values.clone()
        still[swinging] = searched.null[swinging]
        swing = find_swing(Problems(last.problem, last.whitening), still, chance) if swinging else None
        if swing is None:
            return _prepared(base, data, whitened, None)
        logs = swing.in_data(data)
        last = _whitened(base, searched, logs)
    return _prepared(base, logs, last, swing)


def _prepared(base: Refined, logs: Dataset, full: Whitened, swing: Swing | None) -> Prepared:
    """Hypotheses on these logs, counted from no effect."""
    question, searched = base.examined.question, base.searched
    return Prepared(
        **vars(base),
        checked=replace(base.examined.checked, data=logs),
        scored=logs if base.examined.aside is None else base.examined.aside.data,
        candidates=candidates(searched, logs, base.counts),
        problems=Problems(full.problem, full.whitening, nuisance_of(searched, searched.null), full.spread),
        full_fit=full.values,
        origin=searched.null,
        swing=swing,
        not_tested=not_tested(base.model, logs, base.counts, question.exclude, question.include),
    )


def calibrate_base(prepared: Prepared) -> Prepared:
    """Effects counted from what the base itself gets wrong about the plain simulator, where there is one."""
    if prepared.flown is None:
        return prepared
    searched = prepared.problems.library
    own = calibrated(searched, prepared.candidates, prepared.flown, prepared.whitening)
    problems = replace(prepared.problems, nuisance=nuisance_of(searched, own.values))
    return replace(prepared, problems=problems, origin=own.values, calibration=own)


def uncalibrated(prepared: Prepared) -> Prepared:
    """Effects counted from the base as it is, by the same covariance."""
    library, known = prepared.library, prepared.problems.problem
    problem = Problem(library, known.data, known.segments)
    return replace(
        prepared,
        searched=library,
        candidates=candidates(library, known.data, prepared.counts),
        problems=replace(prepared.problems, problem=problem, nuisance=nuisance_of(library, library.null)),
        origin=library.null,
        calibration=None,
        notes=(*prepared.notes, CONTRADICTED),
    )


def _likelier(base: Refined, whitened: Whitened) -> tuple[Refined, Whitened]:
    """The base under which the logs are likelier: that with constants fitted to the simulator, or the one given.

    Constants fitted to motions of a healthy robot may be wrong for those of one that carries a load.
    """
    given = _whitened(base, base.library, base.examined.checked.data)
    deviance, of_given = (own.whitening.deviance(own.residuals) for own in (whitened, given))
    return (base, whitened) if deviance <= of_given else (replace(base, searched=base.library), given)


def _whitened(base: Refined, library: Library, data: Dataset) -> Whitened:
    segments = cut(data, length=base.length)
    return whiten(Problem(library, data, segments), candidates(library, data, base.counts))


def whiten(problem: Problem, effects: tuple[Candidate, ...]) -> Whitened:
    """The covariance of what a fully explained model leaves, from the full model's residuals, at its parameter set.

    Segments start where they most likely did.
    What a model that is far off (an inertia, by twenty times) predicts of whole segments says nothing of the robot's
    slopes. So a full fit to the first part of each goes on to the whole (multiple shooting, from short to long),
    beside one from no effect; where that leaves more, disturbances spread as the full model predicts, not the base.
    """
    null, effects = at_first_count(problem.library, effects)
    segments, fits = problem.segments, list[torch.Tensor]()
    first = replace(segments, measured=segments.measured[:, : round(FIRST * segments.length)])
    for piece in (Problem(problem.library, problem.data, first), problem):
        spread = Spread.of(piece, null)
        left_at_null = piece.residuals(null[None])[0]
        whitening = estimate(spread, left_at_null, segments.noise, segments.channel, alike=True)
        problems = Problems(piece, whitening)
        fits = [full_fit(problems, effects, null), *(full_fit(problems, effects, null, fit) for fit in fits)]
    best = int(problems.totals(fits).argmin())
    values = fits[best]
    problem = _with_likely_starts(problem, spread, whitening, values)
    spread = Spread.of(problem, values if best else null)
    for left in reversed(range(ROUNDS)):
        if left < ROUNDS - 1:
            values = full_fit(Problems(problem, whitening), effects, null, values)
        residuals = problem.residuals(values[None])[0]
        if left == ROUNDS - 1:
            spread = with_wander(spread, residuals, problem.segments, problem.data)
        whitening = estimate(spread, residuals, segments.noise, segments.channel, alike=left == ROUNDS - 1)
    return Whitened(problem, spread, whitening, values)


def _with_likely_starts(problem: Problem, spread: Spread, whitening: Whitening, values: torch.Tensor) -> Problem:
    """The problem with every segment started where that most likely was, given all of it: δ = -P JᵀC⁻¹r.

    The rows before a segment say as little of a rate as ten noisy rows of a derivative at their end. The covariance
    allows for that to first order, which is not enough for what goes by the sign of a rate: dry friction looked half as
    large, and the rest was taken for a disturbance. A segment whose errors the step does not lower keeps its start.
    """
    segments, (residuals,) = problem.segments, problem.residuals(values[None])
    likely = (spread.start.mT @ whitening.inverse_times(residuals[..., None]))[..., 0]
    starts = segments.layout.retract(segments.start, -likely * free_start(segments.layout))
    moved = Problem(problem.library, problem.data, replace(segments, start=starts))
    both = torch.stack([residuals, moved.residuals(values[None])[0]], dim=-1)
    before, after = (whitening.wander.whitened(both).square() * whitening.weight[:, None]).sum(1).unbind(-1)
    starts = torch.where((after < before)[:, None], starts, segments.start)
    return Problem(problem.library, problem.data, replace(segments, start=starts))


def unpredicted_notes(problem: Problem) -> tuple[str, ...]:
    """A sentence where the model without any effect predicts some segments and not others; none where it does all.

    Raises:
        ModelError: when it predicts no segment.
    """
    lost = ~problem.states(problem.library.null[None])[0].isfinite().flatten(1).all(1)
    if lost.all():
        raise ModelError(f"expected a model that predicts finite states along these logs, found none; {ADVICE}")
    note = f"the model predicts no number in {int(lost.sum())} of {len(lost)} segments of the logs: {ADVICE}"
    return (note,) if lost.any() else ()
