"""The base against the plain simulator: its constants fitted once more, then the origin from which effects are counted.

Regression fits single steps. Over a second, errors of a step add up: a car's base may answer its speed command a fifth
too slowly and still be a good one-step model. So the numbers in a learned base's equations, not their form, are fitted
to whole pieces of what the plain simulator does along the logs (``simulator.py``), by the estimator that reads the
logs. Its states carry no noise, so velocities are compared too: a velocity that positions alone bind may drift off by a
tenth, and a force, which acts on it, with it.

A base is still 1 or 2 % wrong, enough to look like an effect. So the same estimator says which effects would explain
its own errors. A car whose speed in fast turns is wrong by a fifth of a percent seems to have a third of its yaw drag
there: what a parameter's score Σ JᵀC⁻¹r is in the simulator, per segment of the same log, the base alone contributes to
it in the log; it is taken away, and a fit moves by one Newton step.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice

import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import COMPARED, Segments, cut
from sym2real.diagnosis.estimate.fit import Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.estimate.full_model import fitted, improved
from sym2real.diagnosis.estimate.variances import LEAST
from sym2real.diagnosis.estimate.whitening import Spread, Whitened, Whitening
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library, Slot
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.kind import Parameter
from sym2real.effects.terms import shielded
from sym2real.logs.noise import component_noise
from sym2real.symbolic import Equations, constants, lift_constants
from sym2real.trajectory import Array

# Relative standard deviation of a constant beforehand; constants that are nearly zero have that of this size.
RELATIVE, SMALL = 0.1, 1e-3
REFINING_STEPS = 4
# Regression writes fewer. Equations of motion of three joints, unrolled over a period, have thousands: masses and
# lengths that the simulator has too. Their normal equations, one matrix a segment, would take tens of gigabytes.
MOST_CONSTANTS = 300


def refined(library: Library, flown: Dataset, logs: Dataset) -> Equations:
    """The base with better constants as parameters; itself where its errors are far below the noise of the logs.

    Itself as well where it has more constants than regression writes.

    Args:
        library: of the base.
        flown: the plain simulator along the logs.
        logs: whose sensors' noise says what matters.
    """
    if len([*islice(constants(library.base), MOST_CONSTANTS + 1)]) > MOST_CONSTANTS:
        return library.base
    noise, segments = component_noise(logs), cut(flown)
    given = _weighted(library, segments, flown, noise)
    if float(given.totals([library.null])) < SETTINGS.worth_saying * given.whitening.freedom:
        return library.base
    free = _of_constants(library.base)
    problems, start = _weighted(free, cut(flown, (*COMPARED, "velocity")), flown, noise), free.null
    values = improved(problems, tuple(range(len(free.slots))), start, start, REFINING_STEPS)
    better = dict(zip((slot.parameter.name for slot in free.slots), values.tolist(), strict=True))
    return replace(lifted(library.base), parameters={**library.base.parameters, **better})


def _weighted(library: Library, segments: Segments, flown: Dataset, noise: Array) -> Problems:
    """Errors weighted by the sensors' noise alone ``# (tangent,)``: what the simulator does, nothing disturbs."""
    problem = Problem(library, flown, segments)
    spread = Spread.of(problem, library.null)
    sensor = torch.as_tensor(noise[list(segments.compared)]).square()
    return Problems(problem, spread.whitening(sensor, sensor.new_full((len(spread.names),), LEAST)))


lifted = lru_cache(maxsize=4)(lift_constants)  # the same equations again, of which libraries are kept


@lru_cache(maxsize=4)
def _of_constants(base: Equations) -> Library:
    """A library whose parameters are the numbers in the base's equations."""
    free = lifted(base)
    numbers = {name: value for name, value in free.parameters.items() if name not in base.parameters}
    slots = tuple(
        Slot("", Parameter(name, "", value, value - 10 * scale, value + 10 * scale, scale), name)
        for name, value in numbers.items()
        for scale in [RELATIVE * max(abs(value), SMALL)]
    )
    return Library(base, shielded(free), {}, slots, shielded(free))


# Number of effects of the base's own, and Gauss–Newton steps.
MOST_EFFECTS, STEPS = 8, 2


@dataclass(frozen=True, eq=False)
class Calibration(Whitened):
    """The base against the plain simulator: flown data, at the parameter set that explains the base's errors there."""

    def scores(self, free: Free, logs: Sequence[str]) -> Tensor:
        """Half the loss's derivative by parameters, mean over the segments here of each log that is named ``# (S, A)``.

        Args:
            free: the parameters.
            logs: name of the log of every segment elsewhere.
        """
        (fit,) = Problems(self.problem, self.whitening).quadratics([Hypothesis(free, self.values)])
        library = self.problem.library
        effects = [library.effects.get(library.slots[slot].effect) for slot in free]
        # Errors have no slope where an effect begins at a threshold.
        smooth = torch.tensor([known is None or known.searching.from_null for known in effects])
        return by_log(torch.where(smooth, fit.gradient, 0.0), self.problem.log_names, logs)


def by_log(gradient: Tensor, own: Sequence[str], logs: Sequence[str]) -> Tensor:
    """Mean over the segments of each named log ``# (len(logs), A)``; for one without any, the mean of the others.

    Args:
        gradient: of every segment ``# (S, A)``.
        own: name of its log.
        logs: names that are asked for.
    """
    means = {name: gradient[[owner == name for owner in own]].mean(0) for name in dict.fromkeys(own)}
    others = torch.stack(list(means.values())).mean(0)
    return torch.stack([means.get(name, others) for name in logs])


def calibrated(library: Library, candidates: Sequence[Candidate], data: Dataset, variances: Whitening) -> Calibration:
    """The effects that would explain the base's errors on the plain simulator's data.

    They are chosen one after the other on one quadratic model, the base's errors being small, while they save enough.
    Priors of their scales hold what those data do not tell: a drag to the side of what has no speed there.

    Args:
        library: effects in the base's equations.
        candidates: what may explain them.
        data: of :func:`~sym2real.diagnosis.estimate.simulator.flown_along`.
        variances: of the logs' whitening, so that errors have the same weights here as there.
    """
    problem = Problem(library, data, cut(data, variances.fields, variances.length))
    spread = Spread.of(problem, library.null)
    problems = Problems(problem, spread.like(variances))
    smooth = [candidate for candidate in candidates if not candidate.needs_start]
    free = tuple(dict.fromkeys(slot for candidate in smooth for slot in candidate.free))
    everything = problems.quadratics([Hypothesis(free, library.null)])[0]
    chosen = _worth_it(problems, everything, smooth, SETTINGS.base_gain * problems.whitening.freedom)
    return Calibration(problem, spread, problems.whitening, fitted(problems, chosen, library.null, library.null, STEPS))


def _worth_it(problems: Problems, everything: Fit, candidates: Sequence[Candidate], least: float) -> list[Candidate]:
    """Candidates that lower the quadratic model's loss by ``least`` each, the best first."""
    chosen, saved = list[Candidate](), 0.0
    while len(chosen) < MOST_EFFECTS:
        trials = []
        for candidate in (candidate for candidate in candidates if candidate not in chosen):
            part = everything.part([slot for other in (*chosen, candidate) for slot in other.free])
            step = problems.best_step(part)
            change = 2 * part.gradient.sum(0) @ step + step @ part.curvature.sum(0) @ step
            # To first order a delay does what a lag does: which of two saves more must not be left to rounding.
            trials.append((float(f"{-change:.6g}"), candidate.name, candidate))
        best = max(trials, default=None)
        if best is None or best[0] - saved < least:
            break
        saved, _, candidate = best
        chosen.append(candidate)
    return chosen


def cleaned(problems: Problems, fit: Fit, own: Calibration | None) -> Fit:
    """The fit where its scores vanish without what the base contributes to them.

    The fit itself without a calibration, and where the logs would then be explained worse than without any effect:
    there the base does not do what it does in the simulator.

    Args:
        problems: what was fitted.
        fit: at its best.
        own: the base against the plain simulator. Logs that were not flown there are cleaned by the mean of the others.
    """
    if own is None or not fit.whole:
        return fit
    shift = own.scores(fit.whole, problems.problem.log_names)
    moved = replace(fit, gradient=fit.gradient - problems.whitening.trust[:, None] * shift)
    step = problems.sure_step(moved, fit)
    values, without = problems.moved(moved, step), fit.values.clone()
    without[list(fit.free)] = own.values[list(fit.free)]
    moved_there, base_alone = problems.totals([values, without]).tolist()
    if moved_there > max(base_alone, fit.total):
        return fit
    return replace(moved, values=values, gradient=moved.gradient + torch.einsum("sab,b->sa", fit.curvature, step))
