"""Fine-tuning of the base itself: the constants of equations fitted to the target's transitions, their form kept.

::

    loss = mean over windows, steps and columns of (e / σ)² + λ · sum over constants of (relative change)²

e and σ are those of :mod:`sym2real.neural.residual_training`. By the recursion of :mod:`sym2real.neural.leftover` the
errors of whole rollouts are linear in small changes of constants, so every λ is one linear ridge regression; where
constants multiply each other, Gauss–Newton steps linearise anew. λ is the largest whose error on the blocks of time
that each of five fits left out is within a standard error of the best (T. Hastie, R. Tibshirani, J. Friedman, "The
Elements of Statistical Learning", section 7.10), and the base stays as it is where that does not improve beyond chance.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.dataset import Transitions
from sym2real.neural import Ensemble, EnsembleTraining, TrainingReport
from sym2real.neural.blocks import Run, blocks_of, windows_in
from sym2real.neural.composed import Base
from sym2real.neural.leftover import errors_by_parameters, leftover
from sym2real.neural.multi_step import Scales, rolled_errors
from sym2real.neural.paired import SURE, sureness
from sym2real.symbolic import Equations, lift_constants
from sym2real.threads import one_thread

STEP = 1e-3  # of relative changes, for differences
AT_ONCE = 16  # constants whose rows are computed together


@dataclass(frozen=True)
class FineTuning:
    """A :class:`~sym2real.protocols.Learner` that changes the base's own numbers instead of adding to it.

    The result is equations of the same form, which fly, print and export like any other. An ensemble is trained further
    from its weights.

    Args:
        steps: rows of a rollout that the loss follows; 1 is the one-step loss.
        penalties: λ to choose from. On 400 rows the smallest takes constants beforehand to be right within a half
            (standard deviation), the largest within half a percent.
        passes: Gauss–Newton steps.
        seed: of the folds; of an ensemble's rows.
    """

    steps: int = 10
    penalties: Sequence[float] = (1e-3, 1e-2, 1e-1, 1.0, 10.0)
    passes: int = 3
    seed: int = 0

    def fit(self, transitions: Transitions, base: Base, start: Base | None = None) -> Base:
        """The base with other numbers.

        Args:
            transitions: of the target.
            base: to begin with, and what λ draws back to; the object itself stays as it is.
            start: has no part: the answer does not depend on the way there.

        Raises:
            ModelError: for too few consecutive transitions.
            ShapeError: for other columns than the base's.
        """
        return self.fit_reported(transitions, base, start)[0]

    def fit_reported(
        self, transitions: Transitions, base: Base, start: Base | None = None
    ) -> tuple[Base, TrainingReport]:
        """The base with other numbers and how that came about; arguments and errors as of :meth:`fit`.

        The report of an ensemble has no λ, and NaN as its error.
        """
        began, rows = time.perf_counter(), len(transitions)
        if isinstance(base, Ensemble):
            shape = EnsembleTraining(base.networks.count, base.widths, base.probabilistic, base.robot, self.seed)
            trained, columns = shape.fit(transitions, base), base.layouts.state.columns
            return trained, TrainingReport(None, math.nan, columns, rows, time.perf_counter() - began)
        with one_thread():
            model, penalty, error = self._tuned(transitions, base)
        columns = tuple(column for column, fitted in model.next.items() if fitted != base.next[column])
        return model, TrainingReport(penalty, error, columns, rows, time.perf_counter() - began)

    def _tuned(self, transitions: Transitions, base: Equations) -> tuple[Equations, float | None, float]:
        lifted = lift_constants(base)
        names = [name for name in lifted.parameters if name not in base.parameters]
        if not names:
            return base, None, 1.0
        problem = Ridge.of(transitions, lifted, names, self.steps, self.seed)
        change, penalty = torch.zeros(problem.fits, len(names), dtype=torch.float64), 0.0
        before = error = problem.validated(change)
        for _ in range(self.passes):
            following, penalty_now = problem.chosen(change[-1], self.penalties)
            now = problem.validated(following)
            if now.mean() >= error.mean():
                break
            change, penalty, error = following, penalty_now, now
        if not sureness(before - error) > SURE:
            return base, None, 1.0
        values = problem.constants * (1.0 + change[-1])
        tuned = lifted.at(**dict(zip(names, values.tolist(), strict=True)))
        return tuned, penalty, float(error.mean() / before.mean())


@dataclass(frozen=True, eq=False)
class Ridge:
    """Errors of rollouts as functions of the relative changes of P constants, and their regression.

    There are as many fits as folds, each of which leaves out its own, and at last the one to all rows.

    Args:
        constants: as the base has them ``# (P,)``.
        errors: one-step errors ``# (rows, t, sets)`` under parameter sets ``# (sets, all parameters)``.
        values: of all parameters ``# (all parameters,)``.
        places: of the constants among them.
        carried: how errors go on ``# (rows, t, t)``.
        blocks: of time.
        fold: of each.
        scales: of errors.
    """

    constants: Tensor
    errors: Callable[[Tensor], Tensor]
    values: Tensor
    places: list[int]
    carried: Tensor
    blocks: list[Run]
    fold: list[int]
    scales: Scales

    @classmethod
    def of(cls, transitions: Transitions, lifted: Equations, names: Sequence[str], steps: int, seed: int) -> Ridge:
        """For the named parameters of equations."""
        rows = leftover(transitions, lifted)
        blocks, fold = blocks_of(rows.runs, steps, seed)
        scales = Scales.of(rows, torch.cat([windows_in(block, steps) for block in blocks]), steps)
        values = torch.tensor(list(lifted.parameters.values()), dtype=torch.float64)
        places = [list(lifted.parameters).index(name) for name in names]
        errors = errors_by_parameters(transitions, lifted)
        return cls(values[places], errors, values, places, rows.carried, blocks, fold, scales)

    @property
    def fits(self) -> int:
        """How many there are."""
        return max(self.fold) + 2

    def validated(self, change: Tensor) -> Tensor:
        """Mean squared error of every block at the changes of who left it out ``# (blocks,)``.

        Where the base is worse than in the mean, in units of its own there: else the first second of a flight, of which
        no other block tells anything, would decide alone.

        Args:
            change: ``# (fits, P)``.
        """
        own = self._of_blocks(torch.zeros_like(change)).clamp(min=1.0)
        return (self._of_blocks(change) / own).nan_to_num(nan=torch.inf)

    def _of_blocks(self, change: Tensor) -> Tensor:
        errors = self.errors(self._sets(change))
        rolled = [
            self._rolled(errors[..., fold : fold + 1], block).square().mean()
            for fold, block in zip(self.fold, self.blocks, strict=True)
        ]
        return torch.stack(rolled)

    def chosen(self, about: Tensor, penalties: Sequence[float]) -> tuple[Tensor, float]:
        """Changes ``# (fits, P)`` for the largest λ that validates within a standard error of the best, and that λ.

        Args:
            about: the change at which errors are linearised ``# (P,)``.
            penalties: λ to choose from.
        """
        curvature, gradient = self._normal_equations(about)
        ordered = sorted(penalties, reverse=True)
        unit = torch.eye(len(about), dtype=torch.float64)
        changes = [torch.linalg.solve(curvature + penalty * unit, -gradient) for penalty in ordered]
        errors = [self.validated(change) for change in changes]
        best = min(errors, key=lambda error: float(error.mean()))
        place = next(place for place, error in enumerate(errors) if sureness(error - best) <= 1.0)
        return changes[place], ordered[place]

    def _sets(self, changes: Tensor) -> Tensor:
        sets = self.values.repeat(len(changes), 1)
        sets[:, self.places] = self.constants * (1.0 + changes)
        return sets

    def _rolled(self, error: Tensor, block: Run, first: Tensor | None = None) -> Tensor:
        """By the scale; arguments as of :func:`~sym2real.neural.multi_step.rolled_errors`."""
        steps = len(self.scales.error)
        return rolled_errors(error, self.carried, windows_in(block, steps), steps, first) / self.scales.error

    def _normal_equations(self, about: Tensor) -> tuple[Tensor, Tensor]:
        """Of the instrumental variables: what is solved for changes ``# (fits, P, P)`` and at none ``# (fits, P)``.

        In a window's first row the instruments are the slopes of the row before, which know nothing of the noise that
        the window starts with and a controller answers.
        """
        slopes = self._slopes(about)
        # What the linearisation says of no change.
        error = self.errors(self._sets(about[None])) - (slopes @ about.float())[..., None]
        both, size = torch.cat([error, slopes], dim=-1), slopes.shape[-1]
        total, count = torch.zeros(self.fits, size, size + 1, dtype=torch.float64), torch.zeros(self.fits, 1, 1)
        for fold, block in zip(self.fold, self.blocks, strict=True):
            instruments = self._rolled(slopes, block, slopes[windows_in(block, len(self.scales.error)) - 1])
            others = torch.arange(self.fits) != fold
            total[others] += instruments.flatten(0, 2).double().mT @ self._rolled(both, block).flatten(0, 2).double()
            count[others] += instruments[..., 0].numel()
        mean = total / count
        return mean[..., 1:], mean[..., 0]

    def _slopes(self, about: Tensor) -> Tensor:
        """Central differences of one-step errors by relative changes ``# (rows, t, P)``."""
        moves = STEP * torch.eye(len(about), dtype=torch.float64)
        pairs = [
            self.errors(self._sets(about + some)) - self.errors(self._sets(about - some))
            for some in moves.split(AT_ONCE)
        ]
        return torch.cat(pairs, dim=-1) / (2.0 * STEP)
