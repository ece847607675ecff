"""Whether parameters differ from none beyond chance: tests on blocks of 1.5 s, or on whole logs."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.estimate.fit import Fit, Hypothesis, Problems
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.least_squares import inflation, inverse_of, solve


def beyond_chance(problems: Problems, fit: Fit, candidate: Candidate, origin: Tensor, tested: int) -> bool:
    """Whether a candidate's parameters differ from none beyond chance; with few blocks nobody can say.

    Args:
        problems: what was fitted.
        fit: of the candidate and others, at its best.
        candidate: the effect, or the effects, in question.
        origin: parameter set without effects ``# (P,)``.
        tested: number of hypotheses that had a chance.
    """
    if problems.block_count < SETTINGS.fewest_pieces:
        return True
    if _far_from_none(problems, Distance.of(problems, fit, candidate, origin), tested):
        return True
    if candidate.needs_start or not collinear(fit, candidate):
        return False
    return _far_from_none(problems, Distance.of_part(problems, fit, candidate, origin), tested)


def collinear(fit: Fit, candidate: Candidate) -> bool:
    """Whether what else is free makes the interval of a parameter of an effect nine times as wide: far, and far again.

    Of two lags in a row with one time, the difference of both times moves next to nothing, and neither time is sure.
    """
    return bool((inflation(fit.curvature.sum(0))[fit.places(candidate.free)] > SETTINGS.far**2).any())


def _far_from_none(problems: Problems, distance: Distance, tested: int) -> bool:
    if _enough_logs(problems, len(distance.away)) and distance.chance(problems.logs) > SETTINGS.false_alarms_by_logs:
        return False
    return distance.chance(problems.blocks) < SETTINGS.false_alarms_of_each(tested)


def beyond_trim(problems: Problems, fit: Fit, candidate: Candidate, origin: Tensor, tested: int) -> bool:
    """Whether whole logs, whose trim differs from run to run, tell a candidate from none at the rate of a data set.

    Few logs have no trim to speak of.

    Args:
        problems, fit, candidate, origin, tested: as of :func:`beyond_chance`.
    """
    if problems.log_count < SETTINGS.fewest_logs:
        return False
    return Distance.of(problems, fit, candidate, origin).chance(problems.logs) < SETTINGS.false_alarms_of_each(tested)


def sizes_beyond_chance(problems: Problems, fit: Fit, tested: int) -> tuple[Tensor, Tensor]:
    """Sizes of an effect's parameters, each alone, from which on :func:`beyond_chance` and :func:`beyond_trim` hold.

    Args:
        problems: what was fitted.
        fit: of the effect where it is none.
        tested: number of hypotheses that had a chance.

    Returns:
        In units of scales ``# (n,), (n,)``: none where nobody can say, infinite where whole logs are too few.
    """
    count, each = len(fit.free), SETTINGS.false_alarms_of_each(tested)
    here = Distance(fit.gradient.new_zeros(count), list(range(count)), fit.gradient, fit.curvature)
    many_logs = problems.log_count >= SETTINGS.fewest_logs
    of_trim = here.sizes_at(each, problems.logs) if many_logs else torch.full_like(here.away, inf)
    if problems.block_count < SETTINGS.fewest_pieces:
        return torch.zeros_like(here.away), of_trim
    sizes = here.sizes_at(each, problems.blocks)
    if _enough_logs(problems, len(sizes)):
        sizes = torch.maximum(sizes, here.sizes_at(SETTINGS.false_alarms_by_logs, problems.logs))
    return sizes, of_trim


def least_gain(problems: Problems, candidate: Candidate, values: Tensor, count: int) -> float:
    """Part of the held-out loss that an effect must save in a set of so many at a parameter set ``# (P,)``.

    Rotors that spin up turn a quadrotor about yaw, one of nine directions of a row: all that they do is less than 1 %
    of the loss of all nine, however plain it is. An effect needs that part of the loss of the directions that it moves.
    """
    needed = SETTINGS.gain_of(count)
    if candidate.needs_start:
        return needed
    (columns,) = problems.problem.linearised(values[None], [candidate.free])
    return needed * problems.whitening.directions(columns[..., 1:])


def _enough_logs(problems: Problems, parameters: int) -> bool:
    """Whether there are logs enough for a test on whole logs of so many parameters."""
    return parameters + 1 < SETTINGS.fewest_logs <= problems.log_count


@dataclass(frozen=True, eq=False)
class Distance:
    """How far parameters are from none, and what tells it.

    Args:
        away: in units of their scales ``# (n,)``.
        places: of these parameters among all that are free.
        gradient, curvature: half the loss's derivatives by all that is free ``# (S, A), (S, A, A)``.
    """

    away: Tensor
    places: list[int]
    gradient: Tensor
    curvature: Tensor

    @classmethod
    def of(cls, problems: Problems, fit: Fit, candidate: Candidate, origin: Tensor) -> Distance:
        """Of an effect in a fit; of one whose null is no value that a fit could be near, the part of it that is there.

        Args:
            problems, fit, candidate, origin: as of :func:`beyond_chance`.
        """
        if candidate.needs_start:
            return cls.of_part(problems, fit, candidate, origin)
        slots, neutral = candidate.slots, origin.clone()
        for slot in problems.nuisance.keys() & slots:  # free in every fit: none as far as its bounds go
            neutral[slot] = fit.values[slot].clamp(*problems.nuisance[slot])
        away = (fit.values - neutral)[slots] / problems.library.scale[slots]
        return cls(away, fit.places(slots), fit.gradient, fit.curvature)

    @classmethod
    def of_part(cls, problems: Problems, fit: Fit, candidate: Candidate, origin: Tensor) -> Distance:
        """Between the predictions without and with an effect a line is drawn: 0 without it, 1 as it was fitted.

        All that is free beside the effect stays free. A part below 0 is none.
        """
        rest = tuple(slot for slot in fit.free if slot not in candidate.free)
        before = problems.fit([Hypothesis(rest, candidate.copied(origin, into=fit.values))])[0]
        beside = tuple(slot for slot in fit.whole if slot not in candidate.free)
        (columns,) = problems.problem.linearised(fit.values[None], [beside])
        whole, slopes = columns[..., :1], columns[..., 1:]
        line = whole - problems.problem.residuals(before.values[None])[0, ..., None]
        products = problems.whitening.products(torch.cat([whole, line, slopes], dim=-1))
        gradient, curvature = products[:, 1:, 0], products[:, 1:, 1:]
        step = solve(curvature.sum(0), -gradient.sum(0))
        return cls((1.0 + step[:1]).clamp_min(0.0), [0], gradient + curvature @ step, curvature)

    def chance(self, clusters: NDArray[np.int64]) -> float:
        """Probability of being so far by chance: Hotelling's test on the jackknife by clusters ``# (S,)``.

        Where one cluster holds all that tells the parameters, they are none without it. J. MacKinnon,
        M. Nielsen, M. Webb, "Cluster-robust inference: a guide to empirical practice", J. Econometrics 232 (2023).
        """
        return chance_of(self.away, *self._spread(clusters))

    def sizes_at(self, chance: float, clusters: NDArray[np.int64]) -> Tensor:
        """How far from none each parameter alone must be for a probability ``# (n,)``; infinite with few clusters."""
        spread, count = self._spread(clusters)
        size, freedom = len(self.away), count - len(self.away)
        if freedom < 2:
            return torch.full_like(self.away, inf)
        squared = float(stats.f.isf(chance, size, freedom)) * size * (count - 1) / freedom
        return (squared / inverse_of(spread).diagonal()).sqrt()

    def _spread(self, clusters: NDArray[np.int64]) -> tuple[Tensor, int]:
        """Jackknife covariance of the parameters by clusters ``# (n, n)``, and the number of these."""
        none = self.gradient - self.curvature[:, :, self.places] @ self.away
        gradient, curvature = (part.sum(0) - summed(part, clusters) for part in (none, self.curvature))
        left_out = -(inverse_of(curvature) @ gradient[..., None])[:, self.places, 0]
        apart, count = left_out - left_out.mean(0), len(left_out)
        return apart.T @ apart * (count - 1) / count, count


def clustered(gradient: Tensor, curvature: Tensor, clusters: NDArray[np.int64]) -> Tensor:
    """Cluster-robust covariance of parameters at their best ``# (A, A)``.

    Args:
        gradient, curvature: half the loss's derivatives ``# (S, A), (S, A, A)``.
        clusters: of every segment ``# (S,)``.
    """
    scores = summed(gradient, clusters)
    count, inverse = len(scores), inverse_of(curvature.sum(0))
    meat = (scores - scores.mean(0)).T @ (scores - scores.mean(0)) * count / max(1, count - 1)
    return inverse @ meat @ inverse


def half_widths(problems: Problems, fit: Fit) -> Tensor:
    """Half-widths of 95 % intervals of the free parameters in units of their scale ``# (A,)``.

    The wider of two Student intervals: on blocks of 1.5 s, which are many, and on logs, which have a trim of their
    own. A parameter that few logs tell has few degrees of freedom there: 1/Σ s² - 1, s the shares of the logs in its
    variance (Satterthwaite's for unequal variances).

    Args:
        problems: what was fitted.
        fit: at its best.
    """
    blocks = clustered(fit.gradient, fit.curvature, problems.blocks).diagonal().clamp_min(0).sqrt()
    half = blocks * float(stats.t.ppf(0.975, max(1, problems.block_count - 1)))
    if problems.log_count < SETTINGS.fewest_logs:
        return half
    inverse = inverse_of(fit.curvature.sum(0))
    moves = summed(fit.gradient, problems.logs) @ inverse
    shares = summed((inverse @ fit.curvature @ inverse).diagonal(dim1=1, dim2=2), problems.logs)
    number = (shares.sum(0).square() / shares.square().sum(0).clamp_min(1e-300)).clamp_min(2.0)
    deviation = (moves.square().sum(0) * number / (number - 1)).sqrt()
    return torch.maximum(half, deviation * torch.as_tensor(stats.t.ppf(0.975, (number - 1).numpy())))


def chance_of(away: Tensor, spread: Tensor, count: int) -> float:
    """Probability of parameters this far from none by chance, by Hotelling's test.

    Args:
        away: the parameters ``# (A,)``.
        spread: their covariance by clusters ``# (A, A)``.
        count: number of clusters.
    """
    size, freedom = len(away), count - len(away)
    if freedom <= 1:
        return 1.0
    squared = float(away @ inverse_of(spread) @ away)
    return float(stats.f.sf(squared * freedom / (size * (count - 1)), size, freedom))


def standard_error(problems: Problems, difference: Tensor) -> float:
    """Standard error of a sum over segments ``# (S,)``, by blocks; of a single block nobody can say."""
    if problems.block_count < 2:
        return inf
    return sqrt(problems.block_count) * float(summed(difference, problems.blocks).std())
