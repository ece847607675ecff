"""Joint Gauss–Newton fits of many hypotheses at once, and what their normal equations say of logs left out.

In every fit numbers are free, within bounds, that nobody knows of a healthy robot, and that are no finding there.
Inertia and the gain of the on-board rate loop are rarely known better than to a tenth. Their ratio sets how fast the
body follows its rate commands, so that the loop's gain is free between 0.8 and 1.25 of the nominal one whatever else is
fitted; ``rate_loop_gain`` is a finding only where the data ask for more than that. What a torque does to the rates goes
by the loop's stiffness, inertia times gain: effects that act by a torque are known no better than that stiffness.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import blocks_of, folds_of, summed
from sym2real.diagnosis.estimate.whitening import Spread, Whitening, free_start
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.least_squares import solve_within

LINE_SEARCH = (1.0, 0.4, 0.1)
# Gauss–Newton steps of a hypothesis that competes.
STEPS = 4
CONVERGED = 1e-4

Free = tuple[int, ...]  # slots of a library
Nuisance = Mapping[int, tuple[float, float]]  # slots of parameters that every hypothesis has free, with their bounds


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Parameters that are free, and where a fit of them starts.

    Args:
        free: slots.
        values: a whole parameter set ``# (P,)``.
    """

    free: Free
    values: Tensor


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis with its quadratic model per segment, in units of the parameters' scales.

    Args:
        free, values: as of a hypothesis.
        held: nuisance parameters, free within bounds of their own, behind the others.
        loss: whitened squares ``# (S,)``.
        gradient: half its derivative ``# (S, A)``.
        curvature: half its second derivative ``# (S, A, A)``.
    """

    free: Free
    held: Free
    values: Tensor
    loss: Tensor
    gradient: Tensor
    curvature: Tensor

    @classmethod
    def of(cls, free: Free, held: Free, values: Tensor, products: Tensor) -> Fit:
        """From products of residuals and their derivatives with each other ``# (S, 1 + A, 1 + A)``."""
        return cls(free, held, values, products[:, 0, 0], products[:, 1:, 0], products[:, 1:, 1:])

    @property
    def total(self) -> float:
        """Whitened squares of all segments."""
        return float(self.loss.sum())

    @property
    def whole(self) -> Free:
        """All that is free."""
        return (*self.free, *self.held)

    def places(self, slots: Sequence[int]) -> list[int]:
        """Where some of the free parameters stand among all of them."""
        return [self.free.index(slot) for slot in slots]

    def part(self, slots: Sequence[int]) -> Fit:
        """The same with some of the free parameters only, and the nuisance."""
        index = [*self.places(slots), *range(len(self.free), len(self.whole))]
        gradient, curvature = self.gradient[:, index], self.curvature[:, index][:, :, index]
        return replace(self, free=tuple(slots), gradient=gradient, curvature=curvature)

    def without(self, slots: Sequence[int], step: Tensor) -> Fit:
        """The same with some of the free parameters moved by a step ``# (len(slots),)`` and no longer free."""
        places = self.places(slots)
        rest = [place for place in range(len(self.whole)) if place not in places]
        gone, across = self.curvature[:, places][:, :, places], self.curvature[:, rest][:, :, places]
        return replace(
            self,
            free=tuple(slot for slot in self.free if slot not in slots),
            loss=self.loss + 2 * self.gradient[:, places] @ step + torch.einsum("a,sab,b->s", step, gone, step),
            gradient=self.gradient[:, rest] + across @ step,
            curvature=self.curvature[:, rest][:, :, rest],
        )

    def after(self, step: Tensor) -> Tensor:
        """Loss of every segment, or fold, by its quadratic model after a step of its own ``# (S, A) -> (S,)``."""
        return self.loss + 2 * (self.gradient * step).sum(1) + torch.einsum("sa,sab,sb->s", step, self.curvature, step)

    def of_segments(self, which: Tensor) -> Fit:
        """The same for some segments only."""
        return replace(self, loss=self.loss[which], gradient=self.gradient[which], curvature=self.curvature[which])

    def mixed(self, which: Tensor, other: Fit) -> Fit:
        """The same for some segments ``# (S,)``, another one of the same parameters elsewhere."""

        def own(here: Tensor, there: Tensor) -> Tensor:
            return torch.where(which.reshape(-1, *[1] * (here.dim() - 1)), here, there)

        loss, gradient = own(self.loss, other.loss), own(self.gradient, other.gradient)
        return replace(self, loss=loss, gradient=gradient, curvature=own(self.curvature, other.curvature))


@dataclass(frozen=True, eq=False)
class Problems:
    """A problem with what weights it: whitening, folds of the cross-validation, blocks of the cluster-robust test.

    Every hypothesis has the nuisance free beside its own parameters.

    Args:
        spread: what shaped the whitening's covariance, where that may be shaped anew.
    """

    problem: Problem
    whitening: Whitening
    nuisance: Nuisance = field(default_factory=dict)
    spread: Spread | None = None
    _known: dict[tuple[Free, bytes, int], Fit] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def folds(self) -> NDArray[np.int64]:
        """Fold of every segment ``# (S,)``: one per log."""
        return folds_of(self.problem.segments)

    @cached_property
    def blocks(self) -> NDArray[np.int64]:
        """Block of every segment, of 1.5 s ``# (S,)``."""
        return blocks_of(self.problem.segments, self.data.dt)

    @property
    def library(self) -> Library:
        """Of the problem."""
        return self.problem.library

    @property
    def data(self) -> Dataset:
        """Logs of the problem."""
        return self.problem.data

    @property
    def block_count(self) -> int:
        """Number of blocks."""
        return int(self.blocks.max()) + 1

    @cached_property
    def logs(self) -> NDArray[np.int64]:
        """Log of every segment, by its number among those that have segments ``# (S,)``."""
        return np.unique(self.problem.segments.log, return_inverse=True)[1].astype(np.int64)

    @property
    def log_count(self) -> int:
        """Number of logs that have segments."""
        return int(self.logs.max()) + 1

    def totals(self, sets: Iterable[Tensor]) -> Tensor:
        """Whitened squares of all segments at each of some parameter sets ``# (P,)``."""
        return self.whitening.loss(self.problem.residuals(torch.stack([*sets]))).sum(1)

    def quadratics(self, hypotheses: Sequence[Hypothesis]) -> list[Fit]:
        """Losses and derivatives where the hypotheses stand."""
        if not hypotheses:
            return []
        sets = torch.stack([hypothesis.values for hypothesis in hypotheses])
        held = [tuple(slot for slot in self.nuisance if slot not in hypothesis.free) for hypothesis in hypotheses]
        whole = [(*hypothesis.free, *others) for hypothesis, others in zip(hypotheses, held, strict=True)]
        parts = zip(hypotheses, held, map(self.whitening.products, self.problem.linearised(sets, whole)), strict=True)
        return [Fit.of(own.free, others, own.values, joint) for own, others, joint in parts]

    def beside(self, before: Free, values: Tensor, others: Sequence[tuple[Free, Tensor]]) -> list[Fit]:
        """Quadratic models of what is free and of some more parameters, each where these start.

        Derivatives by what is free are those at ``values``, of one rollout for all.

        Args:
            before: what is free.
            values: the parameter set where it is best ``# (P,)``.
            others: what is free beside it, and the parameter set to start from.
        """
        if not others:
            return []
        held = tuple(slot for slot in self.nuisance if slot not in before)
        (known,) = self.problem.linearised(values[None], [(*before, *held)])
        own = self.problem.linearised(torch.stack([start for _, start in others]), [free for free, _ in others])
        products = (self.whitening.products(torch.cat([columns, known[..., 1:]], dim=-1)) for columns in own)
        pairs = zip(others, products, strict=True)
        return [Fit.of((*free, *before), held, start, joint) for (free, start), joint in pairs]

    def fit(self, hypotheses: Sequence[Hypothesis], steps: int = STEPS) -> list[Fit]:
        """Gauss–Newton with a line search, all hypotheses in one rollout per step; what was asked before is known."""
        hypotheses = [self._within_nuisance(hypothesis) for hypothesis in hypotheses]
        asked = [(hypothesis.free, hypothesis.values.numpy().tobytes(), steps) for hypothesis in hypotheses]
        new = {key: hypothesis for key, hypothesis in zip(asked, hypotheses, strict=True) if key not in self._known}
        self._known.update(zip(new, self._fit(list(new.values()), steps), strict=True))
        return [self._known[key] for key in asked]

    def _within_nuisance(self, hypothesis: Hypothesis) -> Hypothesis:
        """The same from where nuisance is within its bounds: as a finding beside others it may have been beyond."""
        values = hypothesis.values.clone()
        for slot in self.nuisance.keys() - {*hypothesis.free}:
            values[slot] = values[slot].clamp(*self.nuisance[slot])
        return replace(hypothesis, values=values)

    def _fit(self, hypotheses: Sequence[Hypothesis], steps: int) -> list[Fit]:
        fits = self.quadratics(hypotheses)
        waiting = [i for i, fit in enumerate(fits) if fit.whole]
        for _ in range(steps):
            if not waiting:
                break
            steps_to = [(fits[i], self.best_step(fits[i])) for i in waiting]
            trials = [[self.moved(fit, step * part) for part in LINE_SEARCH] for fit, step in steps_to]
            losses = self.totals(chain(*trials)).reshape(len(waiting), -1)
            gains = {i: fits[i].total - float(lowest) for i, lowest in zip(waiting, losses.amin(1), strict=True)}
            best = zip(waiting, trials, losses.argmin(1).tolist(), strict=True)
            better = {i: Hypothesis(fits[i].free, tried[place]) for i, tried, place in best if gains[i] > 0}
            waiting = [i for i, gain in gains.items() if gain > CONVERGED * fits[i].total]
            for i, fit in zip(better, self.quadratics([*better.values()]), strict=True):
                fits[i] = fit
        return fits

    def moved(self, fit: Fit, step: Tensor) -> Tensor:
        """Parameter set after a step ``# (A,)`` in units of scale, within bounds; what the data do not tell stays."""
        values, slots, (low, high) = fit.values.clone(), list(fit.whole), self._bounds(fit)
        moved = values[slots] + step * self.identifiable(fit) * self.library.scale[slots]
        values[slots] = torch.minimum(torch.maximum(moved, low), high)
        return values

    def identifiable(self, fit: Fit) -> Tensor:
        """Which parameters are identifiable: over its bounds each changes whitened squares by one or more ``# (A,)``.

        A car that never moves sideways has no drag along that axis.
        """
        low, high = self._bounds(fit)
        widths = (high - low) / self.library.scale[list(fit.whole)]
        return fit.curvature.sum(0).diagonal() * widths.square() >= 1.0

    def _bounds(self, fit: Fit) -> tuple[Tensor, Tensor]:
        """Of all that is free in a fit ``# (A,)`` each."""
        low, high = (bound[list(fit.whole)] for bound in self.library.bounds)
        for place, slot in enumerate(fit.held, len(fit.free)):
            low[place], high[place] = self.nuisance[slot]
        return low, high

    def held_out(self, fit: Fit) -> Tensor:
        """Loss of every fold under the parameters that the other folds give ``# (folds,)``.

        Args:
            fit: where its parameters are best, or the quadratic model's best is taken (bounds are heeded).
        """
        return self.left_out(self.by_fold(fit))

    def by_fold(self, fit: Fit) -> Fit:
        """The same summed over the segments of every fold."""
        loss, gradient, curvature = (summed(part, self.folds) for part in (fit.loss, fit.gradient, fit.curvature))
        return replace(fit, loss=loss, gradient=gradient, curvature=curvature)

    def left_out(self, fit: Fit) -> Tensor:
        """As :meth:`held_out`, of a fit that is summed by fold."""
        return fit.after(self._steps_of_others(fit))

    def held_out_segments(self, fit: Fit) -> Tensor:
        """As :meth:`held_out`, of every segment ``# (S,)``."""
        return fit.after(self._steps_of_others(self.by_fold(fit))[torch.as_tensor(self.folds)])

    def by_own_starts(self, fit: Fit) -> Tensor:
        """What every fold's loss changes by where free starts move segments as the fit's own values say ``# (folds,)``.

        The covariance has starts move them as other values say. Where an unknown start of a velocity turns a robot
        because its wheels differ, the wheels are not to blame.
        """
        if self.spread is None:
            return fit.loss.new_zeros(int(self.folds.max()) + 1)
        start = self.problem.start_jacobian(fit.values) * free_start(self.problem.segments.layout)
        own = replace(replace(self.spread, start=start).like(self.whitening), trust=self.whitening.trust)
        residuals = self.problem.residuals(fit.values[None])
        return summed((own.loss(residuals) - self.whitening.loss(residuals))[0], self.folds)

    def _steps_of_others(self, fit: Fit) -> Tensor:
        """For every fold the step to the minimum of the quadratic model of the other folds ``# (folds, A)``."""
        others_g, others_h = fit.gradient.sum(0) - fit.gradient, fit.curvature.sum(0) - fit.curvature
        return self._lowest(fit, others_h, others_g) if fit.whole else others_g

    def _lowest(self, fit: Fit, curvature: Tensor, gradient: Tensor) -> Tensor:
        """Step to the minimum of quadratic models within bounds ``# (..., A)``."""
        (low, high), slots = self._bounds(fit), list(fit.whole)
        values, unit = fit.values[slots], self.library.scale[slots]
        low, high = ((bound - values) / unit for bound in (low, high))
        return solve_within(curvature, -gradient, low, high)

    def best_step(self, fit: Fit) -> Tensor:
        """Step to the quadratic model's minimum within bounds ``# (A,)``."""
        return self._lowest(fit, fit.curvature.sum(0), fit.gradient.sum(0))

    def sure_step(self, fit: Fit, whole: Fit) -> Tensor:
        """As much of the best step, if any, as the quadratic model of all segments holds for ``# (A,)``.

        How its base rolls is nothing to an arm that swings upright but a little less weight: at none the slope is none,
        and a step along it may go anywhere.

        Args:
            fit: of some segments, or with other scores.
            whole: about the same values, of all segments.
        """
        best = self.best_step(fit)
        steps = [part * best for part in (*LINE_SEARCH, 0.0)]
        predicted = torch.stack([whole.after(step.expand(len(whole.loss), -1)).sum() for step in steps])
        holds = self.totals([self.moved(whole, step) for step in steps]) <= (1 + SETTINGS.worth_saying) * predicted
        return steps[int(holds.int().argmax())]


def nuisance_of(library: Library, origin: Tensor) -> Nuisance:
    """The nuisance of a library around what is known of its base ``# (P,)``."""
    known = [(slot, effect.of.nuisance) for key, effect in library.effects.items() for slot in library.indices(key)]
    bounds = [(slot, float(origin[slot]), factors) for slot, factors in known if factors is not None]
    return {slot: (low * here, high * here) for slot, here, (low, high) in bounds}
