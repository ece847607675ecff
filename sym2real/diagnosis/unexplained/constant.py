"""A constant disturbance without a name in the library: no feature explains it, and whitening hides it.

The covariance's variances take a constant for a disturbance of that size. So every channel's constant is estimated by
generalised least squares on the whitened residuals, d = -Σ JᵀC⁻¹r / Σ JᵀC⁻¹J, and must be far from zero beside its
scatter from log to log, which holds the trim that differs from run to run. The residuals are those of the
best fit, to whose parameters they are orthogonal: what a finding explains already is not counted again.

A constant of every log's own (wind on several days, a load in some flights) is held against its change from the first
half of logs to the second, by the analysis of variance in one way (R. Fisher, "Statistical Methods for Research
Workers", 1925, chapter 7).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy import stats
from torch import Tensor

from sym2real.diagnosis.data.segments import Segments, summed
from sym2real.diagnosis.estimate.calibrate import Calibration
from sym2real.diagnosis.estimate.whitening import PIECES, Whitened
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.select import Selection
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, TermFit
from sym2real.diagnosis.unexplained.features import part_of_disturbance
from sym2real.diagnosis.unexplained.leftover import LOG, Leftover, unit_of
from sym2real.effects.kind import with_unit
from sym2real.effects.wrench import AXES
from sym2real.trajectory import Array

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
    def of(cls, whitened: Whitened) -> Constants:
        """Of a data set at its parameter set."""
        problem, spread = whitened.problem, whitened.spread
        offsets = _offsets(problem)
        shapes = [offset.expand(len(problem.segments), -1)[..., None] for _, _, offset in offsets]
        columns = torch.cat([spread.disturbances.sum(dim=-1) / spread.sizes, *shapes], dim=-1)  # (S, R, D)
        weighted = whitened.whitening.products(torch.cat([whitened.residuals[..., None], columns], dim=-1))
        names = (*spread.names, *(name for name, _, _ in offsets))
        units = (*(unit_of(problem, name) for name in spread.names), *(unit for _, unit, _ in offsets))
        return cls(names, units, weighted[:, 0, 1:], weighted[:, 1:, 1:])

    @property
    def sizes(self) -> Tensor:
        """What each would have to be in the model, in its unit ``# (D,)``."""
        return -self.gradient.sum(0) / self.coupling.sum(0).diagonal().clamp_min(1e-300)

    def beside(self, place: int) -> Constants:
        """What the others have to explain once this one stands at its size."""
        return replace(self, gradient=self.gradient + self.coupling[:, :, place] * self.sizes[place])

    def alone(self, place: int) -> TermFit:
        """One of them as a term beside nothing."""
        own = [place]
        return TermFit(place, CONSTANT, 0, self.gradient[:, own], self.coupling[:, own][:, :, own])


def find_constants(selection: Selection, here: Whitened, own: Calibration | None = None) -> tuple[Leftover, ...]:
    """Constants that are beyond chance and matter: the one that lowers held-out errors most, then others beside it.

    Args:
        selection: what was found.
        here: the logs at its values.
        own: the base against the plain simulator: a channel in which it is off as much there shows its own fault.
    """
    problems, constants = selection.problems, Constants.of(here)
    of_base = torch.zeros(1) if own is None else Constants.of(own).sizes
    waiting = {*range(len(constants.names))}
    least = (SETTINGS.gain_few if selection.chosen else SETTINGS.gain) * selection.present.loss
    # Every log has a trim of its own, where there are logs enough.
    clusters = problems.blocks if problems.log_count < SETTINGS.fewest_logs else problems.logs
    chance, leftovers = SETTINGS.false_alarms_of_each(len(constants.names)), list[Leftover]()
    while True:
        robots = (of_base.abs() <= SETTINGS.mostly * constants.sizes.abs()).tolist()
        falls = {place: constants.alone(place).fall(problems.folds) for place in waiting if robots[place]}
        counts = [p for p in falls if falls[p] > least and constants.alone(p).chance(clusters) < chance]
        if not counts:
            return tuple(leftovers)
        place = max(counts, key=falls.__getitem__)
        size, unit = float(constants.sizes[place]), constants.units[place]
        share, term = falls[place] / constants.alone(place).most, f"{with_unit(size, unit)} everywhere"
        name, segments = constants.names[place], problems.problem.segments
        motion = part_of_disturbance(segments, here.spread, name, size) if name in here.spread.names else None
        leftovers.append(Leftover(CONSTANT, name, min(1.0, share), term, size, unit, motion))
        waiting.discard(place)
        constants = constants.beside(place)


def find_differing(selection: Selection, here: Whitened, own: Calibration | None = None) -> tuple[Leftover, ...]:
    """Disturbances nearly all of whose squares are between logs, and that matter; the one that moves most first.

    Args:
        selection, here, own: as of :func:`find_constants`.
    """
    problems, leftovers = selection.problems, list[Leftover]()
    if problems.log_count < SETTINGS.fewest_logs:
        return ()
    segments, data, spread, constants = problems.problem.segments, problems.data, here.spread, Constants.of(here)
    chances, shares, sizes = _by_log(constants, segments)
    of_base = np.zeros(len(constants.names))
    if own is not None:
        of_base = _by_log(Constants.of(own), own.problem.segments)[2].std(0)
    logs, place_of = np.unique(segments.log, return_inverse=True)
    for place, name in enumerate(spread.names):
        apart, unit = sizes[:, place] - sizes[:, place].mean(), constants.units[place]
        sure = chances[place] < SETTINGS.false_alarms_of_each(len(spread.names)) and shares[place] > SETTINGS.nearly
        if sure and of_base[place] <= SETTINGS.mostly * apart.std():
            motion = part_of_disturbance(segments, spread, name, np.repeat(apart[place_of], PIECES))
            ends = [(sizes[at, place], data[int(logs[at])].name) for at in (apart.argmin(), apart.argmax())]
            words = " and ".join(f"{with_unit(size, unit)} in {log}" for size, log in ends)
            leftovers.append(Leftover(LOG, name, float(shares[place]), words, motion=motion))
    return tuple(sorted((entry for entry in leftovers if entry.matters), key=lambda entry: -(entry.motion or 0.0)))


def _by_log(constants: Constants, segments: Segments) -> tuple[Array, Array, Array]:
    """Chance that logs differ so, the part ω² of squares that is between them ``# (D,)``, constants ``# (logs, D)``.

    Within a log its halves differ, as by gusts that last for seconds.
    """
    logs, numbers = np.unique(segments.log, return_inverse=True)[1], np.arange(len(segments))
    middle = np.array([np.median(numbers[logs == log]) for log in range(logs.max() + 1)])
    halves = np.unique(2 * logs + (numbers > middle[logs]), return_inverse=True)[1]
    parts = constants.gradient, constants.coupling.diagonal(dim1=1, dim2=2)
    sums = [[summed(part, by) for part in parts] for by in (np.zeros_like(logs), logs, halves)]
    whole, by_log, by_half = ((force.square() / hold.clamp_min(1e-300)).sum(0).numpy() for force, hold in sums)
    freedom = logs.max(), max(1, halves.max() - logs.max())
    between, unit = by_log - whole, np.maximum(by_half - by_log, 1e-300) / freedom[1]
    share = (between - freedom[0] * unit) / (by_half - whole + unit)
    sizes = -sums[1][0] / sums[1][1].clamp_min(1e-300)
    return stats.f.sf(between / freedom[0] / unit, *freedom), share, sizes.numpy()


def _offsets(problem: Problem) -> list[tuple[str, str, Tensor]]:
    """Name, unit, and shape in the residual ``# (R,)`` of every measurement that may be off by a constant."""
    segments = problem.segments
    offsets = []
    for place, (component, number) in enumerate(zip(segments.compared, segments.channel, strict=True)):
        owner, places = segments.layout.fields[number], segments.layout.tangent_places[number]
        if owner.name not in MEASURED:
            continue
        name = f"measured {owner.name}" + (f" {AXES[component - places.start]}" if len(places) > 1 else "")
        shape = torch.eye(len(segments.compared), dtype=torch.float64)[place].repeat(segments.length)
        offsets.append((name, MEASURED[owner.name], shape))
    return offsets
