"""What the base model itself gets wrong about the plain simulator: the origin from which effects are counted.

A learned base is 1 or 2 % wrong, enough to look like an effect. So the plain simulator flies along every log's
reference (else along its smoothed path) with the nominal geometric controller and the log's quick changes of command,
and the same estimator says which effects would explain the base's own errors. The simulator's states carry no noise:
what is said of the base is then exact, and its uncertainty need not be added to every finding's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.estimate.fit import Fit, Free, Hypothesis, Problems
from sym2real.diagnosis.estimate.flying import fly
from sym2real.diagnosis.estimate.whitening import Spread, Whitening
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.plants import MujocoPlant
from sym2real.trajectory import Array, Trajectory

# A car's figure of eight takes 300 rows: of its first half alone the base's own errors look like an arm to one side.
# Of fast logs as long as of a quadrotor's at 50 Hz.
MOST_LOGS, MOST_ROWS, MOST_SECONDS = 8, 400, 8.0
# Number of effects of the base's own, and Gauss–Newton steps.
MOST_EFFECTS, STEPS = 8, 2
# Rows over which a path is smoothed, and over which changes of a command count as quick.
SMOOTHING, QUICK = 9, 15


def _smoothed(columns: Array, rows: int) -> Array:
    """Moving average over an odd number of rows ``# (rows, columns)``."""
    padded = np.pad(columns, ((rows // 2, rows // 2), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, np.ones(rows) / rows, "valid") for column in padded.T], axis=1)


def simulated(plant: MujocoPlant, data: Dataset) -> Dataset | None:
    """The logs' manoeuvres in the plain simulator; None where none of them can be flown."""
    flights = [_flight(plant, trajectory) for trajectory in list(data)[:MOST_LOGS]]
    long_enough = [flight for flight in flights if len(flight) >= SETTINGS.base_rows]
    return Dataset(long_enough) if long_enough else None


def _flight(plant: MujocoPlant, log: Trajectory) -> Trajectory:
    robot, path = plant.robot, reference_of(log)
    steps = min(len(log), max(MOST_ROWS, round(MOST_SECONDS / log.dt)))

    def reference(time: Tensor) -> Tensor:
        rows = (time / log.dt).clamp(0, len(path) - 1)
        low = rows.floor().long().clamp(max=len(path) - 2)
        part = (rows - low)[..., None]
        blended = (1 - part) * path[low] + part * path[low + 1]
        return robot.layouts.state.normalise(blended)

    dither = (log.action - _smoothed(log.action, QUICK))[:steps]
    return fly(plant, reference, dither, start=log.state[0], name=log.name)


def reference_of(log: Trajectory) -> Tensor:
    """Full reference state along a log ``# (rows, state)``: its columns ``ref_…``, the smoothed path for the others."""
    layout = log.layouts.state
    path = _smoothed(log.state, SMOOTHING)
    coordinate_of = {rate: coordinate for coordinate, rate in layout.rates.items()}
    if all(f"ref_{column}" in log.extra for field in layout.placing for column in field.columns):
        for column in layout:
            place = layout.index(column)
            if f"ref_{column}" in log.extra:
                path[:, place] = log.extra[f"ref_{column}"]
            elif f"ref_{coordinate_of.get(column)}" in log.extra:
                path[:, place] = np.gradient(log.extra[f"ref_{coordinate_of[column]}"], log.time)
    return layout.normalise(torch.as_tensor(path))


@dataclass(frozen=True, eq=False)
class Calibration:
    """The base against the plain simulator.

    Args:
        problem, spread, whitening: of the flown data.
        origin: parameter set that explains the base's errors there ``# (P,)``.
    """

    problem: Problem
    spread: Spread
    whitening: Whitening
    origin: Tensor

    def scores(self, free: Free, logs: Sequence[str]) -> Tensor:
        """Half the loss's derivative by parameters, mean over the segments here of each log that is named ``# (S, A)``.

        Args:
            free: the parameters.
            logs: name of the log of every segment elsewhere.
        """
        here = Hypothesis(free, self.origin)
        (fit,) = Problems.of(self.problem, self.whitening).quadratics([here], with_nuisance=False)
        smooth = torch.tensor([all(self._is_smooth(slot) for slot in tied) for tied in free])
        return by_log(torch.where(smooth, fit.gradient, 0.0), self.problem.log_names, logs)

    def _is_smooth(self, slot: int) -> bool:
        """Whether errors have a slope at the parameter's null: an effect that begins at a threshold may jump there."""
        library = self.problem.library
        key = library.slots[slot].effect
        return not key or library.effects[key].searching.from_null


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

    Args:
        library: effects in the base's equations.
        candidates: what may explain them.
        data: of :func:`simulated`.
        variances: of the logs' whitening, so that errors weigh here as they weigh there.
    """
    problem = Problem(library, data)
    spread = Spread.of(problem, library.null)
    whitening = spread.like(variances)
    problems = Problems.of(problem, whitening)
    smooth = [candidate for candidate in candidates if not candidate.needs_start]
    free = tuple(dict.fromkeys(tied for candidate in smooth for tied in candidate.free))
    everything = problems.quadratics([Hypothesis(free, library.null)])[0]
    chosen = _worth_it(problems, everything, smooth, SETTINGS.base_gain * whitening.freedom)
    hypothesis = Hypothesis(tuple(tied for candidate in chosen for tied in candidate.free), library.null)
    return Calibration(problem, spread, whitening, problems.fit([hypothesis], STEPS)[0].values)


def _worth_it(problems: Problems, everything: Fit, rivals: Sequence[Candidate], least: float) -> list[Candidate]:
    """Candidates that lower the quadratic model's loss by ``least`` each, the best first."""
    places = {tied: place for place, tied in enumerate(everything.free)}
    chosen: list[Candidate] = []
    saved = 0.0
    while len(chosen) < MOST_EFFECTS:
        trials = []
        for candidate in (candidate for candidate in rivals if candidate not in chosen):
            part = everything.part([places[tied] for other in (*chosen, candidate) for tied in other.free])
            step = problems.best_step(part)
            change = 2 * part.gradient.sum(0) @ step + step @ part.curvature.sum(0) @ step
            trials.append((-float(change), candidate.name, candidate))
        best = max(trials, default=None)
        if best is None or best[0] - saved < least:
            break
        saved, _, candidate = best
        chosen.append(candidate)
    return chosen
