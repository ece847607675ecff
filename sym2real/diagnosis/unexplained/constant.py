"""A constant disturbance without a name in the library: no feature explains it, and whitening hides it.

The covariance's variances take a constant for a disturbance of that size. So every channel's constant is estimated by
generalised least squares on the whitened residuals, d = -Σ JᵀC⁻¹r / Σ JᵀC⁻¹J, and must be far from zero beside its
scatter from log to log, which holds the trim that differs from run to run. The residuals are those of the
best fit, to whose parameters they are orthogonal: what a finding explains already is not counted again.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.parts import summed
from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.whitening import Spread, Whitening
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.leftover import Leftover, unit_of
from sym2real.diagnosis.unexplained.motion import part_of_disturbance
from sym2real.effects.wrench import AXES

CONSTANT = "constant"
# Measurements that may be off by a constant which the free start does not take up, and their unit.
MEASURED = {"attitude": "rad", "heading": "rad", "rate": "rad/s"}


@dataclass(frozen=True, eq=False)
class Constants:
    """Every channel's constant disturbance, on its own.

    Args:
        names, units: of the channels.
        gradient: half the derivative of the whitened squares by each, in its unit ``# (S, D)``.
        coupling: half their second derivatives ``# (S, D, D)``.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    gradient: Tensor
    coupling: Tensor

    @classmethod
    def of(cls, problem: Problem, spread: Spread, whitening: Whitening, values: Tensor) -> Constants:
        """At a parameter set ``# (P,)``."""
        offsets = _offsets(problem)
        shapes = [offset.expand(len(problem.segments), -1)[..., None] for _, _, offset in offsets]
        columns = torch.cat([spread.disturbances.sum(dim=-1) / spread.sizes, *shapes], dim=-1)  # (S, R, D)
        residual = problem.residuals(values[None])[0]
        weighted = whitening.products(torch.cat([residual[..., None], columns], dim=-1))
        names = (*spread.names, *(name for name, _, _ in offsets))
        units = (*(unit_of(problem, name) for name in spread.names), *(unit for _, unit, _ in offsets))
        return cls(names, units, weighted[:, 0, 1:], weighted[:, 1:, 1:])

    @property
    def curvature(self) -> Tensor:
        """Of each alone ``# (S, D)``."""
        return self.coupling.diagonal(dim1=1, dim2=2)

    @property
    def sizes(self) -> Tensor:
        """What each would have to be in the model, in its unit ``# (D,)``."""
        return -self.gradient.sum(0) / self.curvature.sum(0).clamp_min(1e-300)

    def beside(self, place: int) -> Constants:
        """What the others have to explain once this one stands at its size."""
        return replace(self, gradient=self.gradient + self.coupling[:, :, place] * self.sizes[place])

    def held_out(self, folds: NDArray[np.int64]) -> tuple[Tensor, Tensor]:
        """Fall of the loss by each constant of the other folds, and the most that one a fold could give ``# (D,)``."""
        gradient, curvature = (summed(part, folds) for part in (self.gradient, self.curvature))
        others = (curvature.sum(0) - curvature).clamp_min(1e-300)
        step = -(gradient.sum(0) - gradient) / others
        fall = -(2 * gradient * step + curvature * step.square()).sum(0)
        return fall, (gradient.square() / curvature.clamp_min(1e-300)).sum(0)

    def p_values(self, clusters: NDArray[np.int64]) -> Tensor:
        """Probability of constants this far from zero by chance ``# (D,)``: Student's t over clusters, -1 for none."""
        sizes = self.sizes
        scores = summed(self.gradient + self.curvature * sizes, clusters)
        count, whole = len(scores), self.curvature.sum(0).clamp_min(1e-300)
        inflation = len(clusters) / max(1, int(np.sum(clusters >= 0)))
        variance = (scores - scores.mean(0)).square().sum(0) * inflation * count / max(1, count - 1) / whole.square()
        ratio = sizes.abs() / variance.sqrt().clamp_min(1e-300)
        return torch.as_tensor(2 * stats.t.sf(ratio.numpy(), max(1, count - 1)))


def find_constants(
    selection: Selection, spread: Spread, own: Calibration | None = None, exclude: Collection[str] = ()
) -> tuple[Leftover, ...]:
    """Constants that are beyond chance and matter: the one that lowers held-out errors most, then others beside it.

    Args:
        selection: what was found.
        spread: shapes of the disturbances.
        own: the base against the plain simulator: a channel in which it is off as much there shows its own fault.
        exclude: channels of which something else is said.
    """
    problems = selection.problems
    if problems.block_count < SETTINGS.fewest_pieces:
        return ()
    constants = Constants.of(problems.problem, spread, problems.whitening, selection.fit.values)
    of_base = None if own is None else Constants.of(own.problem, own.spread, own.whitening, own.origin).sizes
    waiting = torch.tensor([name not in exclude for name in constants.names])
    least = (SETTINGS.gain_few if selection.chosen else SETTINGS.gain) * selection.loss
    chances, leftovers = SETTINGS.false_alarms / len(constants.names), list[Leftover]()
    while True:
        fall, most = constants.held_out(problems.folds)
        counts = waiting & (fall > least) & (constants.p_values(_clusters(problems)) < chances)
        if of_base is not None:
            counts &= of_base.abs() <= SETTINGS.mostly * constants.sizes.abs()
        if not bool(counts.any()):
            return tuple(leftovers)
        place = int(torch.where(counts, fall, -torch.inf).argmax())
        size, unit = float(constants.sizes[place]), constants.units[place]
        share, term = float(fall[place] / most[place]), f"{size:.3g} {unit} everywhere"
        name, segments = constants.names[place], problems.problem.segments
        motion = part_of_disturbance(segments, spread, name, size) if name in spread.names else None
        leftovers.append(Leftover(CONSTANT, name, share, term, size, unit, motion))
        waiting[place] = False
        constants = constants.beside(place)


def _clusters(problems: Problems) -> NDArray[np.int64]:
    """Logs, each with a trim of its own; blocks of a second where there are few."""
    return problems.blocks if problems.log_count < SETTINGS.fewest_logs else problems.logs


def _offsets(problem: Problem) -> list[tuple[str, str, Tensor]]:
    """Name, unit, and shape in the residual ``# (R,)`` of every measurement that may be off by a constant."""
    segments = problem.segments
    found = []
    for place, (component, number) in enumerate(zip(segments.compared, segments.channel, strict=True)):
        owner, places = segments.layout.fields[number], segments.layout.tangent_places[number]
        if owner.name not in MEASURED:
            continue
        name = f"measured {owner.name}" + (f" {AXES[component - places.start]}" if len(places) > 1 else "")
        shape = torch.zeros(segments.length, len(segments.compared), dtype=torch.float64)
        shape[:, place] = 1.0
        found.append((name, MEASURED[owner.name], shape.flatten()))
    return found
