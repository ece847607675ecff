"""Every effect fitted at once, held by priors: a model that misses little, though it may have the wrong reasons.

What it leaves shows noise and small disturbances, from which the whitening is estimated. The parameters of a few
thousand residuals are few dozen, so that fitting all of them takes less than a hundredth of the noise away.
"""

from collections.abc import Sequence

import numpy as np
import torch
from scipy.optimize import lsq_linear
from torch import Tensor

from sym2real.diagnosis.estimate.fit import CONVERGED, LINE_SEARCH, Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.trajectory import Array

# Gauss–Newton steps from the start, and from the result with another whitening.
STEPS, AGAIN = 4, 2
# Precision of a parameter beforehand, in units of its scale.
PRIOR = 1.0
# Part of a curvature that may be rounding: what is left of it after the free starts of segments are projected out.
ROUNDING = 1e-9


def full_fit(problems: Problems, competing: Sequence[Candidate], start: Tensor, last: Tensor | None = None) -> Tensor:
    """Parameter set ``# (P,)`` of the fit of everything.

    Args:
        problems: data with a first whitening.
        competing: effects that compete.
        start: where the fit starts, the mean of the priors ``# (P,)``.
        last: result with an earlier whitening, to go on from ``# (P,)``.
    """
    smooth, others = ([candidate for candidate in competing if candidate.needs_start is flag] for flag in (False, True))
    if last is not None:
        kept = [candidate for candidate in others if last[candidate.free[0]] != start[candidate.free[0]]]
        # Means of the priors: those of effects whose null is infinitely far are where they have been found.
        centre, slots = start.clone(), [slot for candidate in kept for slot in candidate.slots]
        centre[slots] = last[slots]
        return fitted(problems, [*smooth, *kept], centre, last, AGAIN)
    fits = [fitted(problems, smooth, start, start, STEPS)]
    for candidates in (others, smooth):
        away, started = _with_a_start(problems, candidates, start)
        if started:
            fits.append(fitted(problems, [*smooth, *started], away, away, STEPS))
    return fits[int(problems.totals(fits).argmin())]


def fitted(problems: Problems, chosen: Sequence[Candidate], centre: Tensor, values: Tensor, steps: int) -> Tensor:
    """As :func:`improved`, with all parameters of some effects free."""
    free = tuple(dict.fromkeys(slot for candidate in chosen for slot in candidate.free))
    return improved(problems, free, values, centre, steps)


def _with_a_start(problems: Problems, competing: Sequence[Candidate], values: Tensor) -> tuple[Tensor, list[Candidate]]:
    """The parameter set with the one candidate that saves most by itself, if any saves much."""
    trials = [(candidate, candidate.started(values, level)) for candidate in competing for level in candidate.starts]
    without, *losses = problems.totals([values, *(started for _, started in trials)]).tolist()
    if not trials or min(losses) > (1 - SETTINGS.another_effect) * without:
        return values, []
    candidate, started = trials[losses.index(min(losses))]
    return started, [candidate]


def improved(problems: Problems, free: Free, values: Tensor, centre: Tensor, steps: int) -> Tensor:
    """Gauss–Newton steps within bounds, the prior's mean at ``centre``, until another is not worth it."""
    slots = list(free)
    for _ in range(steps if free else 0):
        fit = problems.quadratics([Hypothesis(free, values)])[0]
        step = _bounded_step(problems, fit, centre)
        trials = torch.stack([values, *(problems.moved(fit, step * part) for part in LINE_SEARCH)])
        away = (trials[:, slots] - centre[slots]) / problems.library.scale[slots]
        losses = torch.cat([fit.loss.sum()[None], problems.totals(trials[1:])]) + PRIOR * away.square().sum(1)
        best = int(losses.argmin())
        values = trials[best]
        if not bool(losses[0] - losses[best] > CONVERGED * losses[0]):
            break
    return values


def _bounded_step(problems: Problems, fit: Fit, centre: Tensor) -> Tensor:
    """Minimum of the quadratic model and the prior within bounds, as a step in units of scale ``# (A,)``."""
    library, slots = problems.library, list(fit.free)
    values, unit = fit.values[slots], library.scale[slots]
    factor = root(fit.curvature.sum(0).numpy() + PRIOR * np.eye(len(slots)))
    gradient = fit.gradient.sum(0).numpy() + PRIOR * ((values - centre[slots]) / unit).numpy()
    low, high = (((bound[slots] - values) / unit).numpy() for bound in library.bounds)
    target, bounds = -np.linalg.solve(factor, gradient), (np.minimum(low, -1e-12), np.maximum(high, 1e-12))
    return torch.as_tensor(lsq_linear(factor.T, target, bounds, method="bvls").x)


def root(curvature: Array) -> Array:
    """A square root L of a curvature that rounding may have made indefinite, L Lᵀ ``# (A, A)``.

    Logs almost without noise have so large a weight that rounding exceeds the prior, where they are short by far.
    """
    scale = np.sqrt(curvature.diagonal())[:, None]
    values, vectors = np.linalg.eigh(curvature / (scale * scale.T))
    return np.asarray(scale * vectors * np.sqrt(np.maximum(values, ROUNDING)))
