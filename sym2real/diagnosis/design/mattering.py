"""From which size on an effect matters for predictions, whether or not logs show smaller ones.

A model that lacks an effect of size β predicts channel c with the mean square error f² + β²s²: f is the floor that
noise and disturbances make for any model (see ``errors/floor.py``), s² the mean square of the prediction's derivative
by β at the window's end. The effect matters where a tenth of that error goes with it, which is what the gate asks of
findings: β² ≥ (1/0.9² - 1) f²/s² in the channel and at the horizon that show it best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.diagnosis.data.windows import channel_name, judged
from sym2real.diagnosis.errors.floor import MOST_WINDOWS, Floor, SensorNoise, floor_of_explained
from sym2real.diagnosis.errors.rungs import windows_of
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.quadratic import Free
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.search.needed import judged_horizons
from sym2real.diagnosis.settings import SETTINGS

# Mean square of what an effect changes, over the floor's, of which a tenth of the error goes with the effect.
MATTERS = 1 / (1 - SETTINGS.worth_saying) ** 2 - 1


@dataclass(frozen=True, eq=False)
class Predictions:
    """Windows as long as those by which findings are judged, and the floor of their errors.

    Args:
        problem: predictions of the windows.
        floor: at every horizon that is judged.
    """

    problem: Problem
    floor: Sequence[Floor]

    @classmethod
    def of(cls, problems: Problems, noise: SensorNoise | None) -> Predictions | None:
        """Of the logs of a problem, with noise of the sensors or that which the logs show; None of short logs."""
        library, data = problems.problem.library, problems.problem.data
        horizons = judged_horizons(data, 0.0)
        windows = windows_of(data, round(max(horizons) / data.dt)) if horizons else None
        if windows is None:
            return None
        floor = floor_of_explained(library, data, library.null, problems.whitening, horizons, noise=noise)
        return cls(Problem(library, data, windows.some(MOST_WINDOWS)), floor)

    def of_parameters(self, free: Free) -> Tensor:
        """Size of every parameter from which on it matters, in units of its scale ``# (A,)``."""
        null = self.problem.library.null
        slopes = self.problem.linearised(null[None], [free])[0][..., 1:]
        return (MATTERS / self._over_floor(slopes)).sqrt()

    def matter(self, sets: Tensor) -> Tensor:
        """Which of some parameter sets ``# (B, P)`` matter beside none ``# (B,)``."""
        residuals = self.problem.residuals(torch.cat([self.problem.library.null[None], sets]))
        return self._over_floor((residuals[1:] - residuals[0]).permute(1, 2, 0)) > MATTERS

    def _over_floor(self, changes: Tensor) -> Tensor:
        """Mean squares of changed predictions ``# (W, R, B)`` over the floor's, where they are largest ``# (B,)``."""
        windows, dt = self.problem.segments, self.problem.data.dt
        squares = changes.square().mean(0).reshape(windows.length, len(windows.compared), -1)
        channel = torch.tensor(windows.channel)
        numbers = {channel_name(field): number for number, field in enumerate(windows.layout.fields)}
        ratios = [
            squares[round(level.horizon / dt), channel == numbers[name]].sum(0) / max(level.errors[name][0], 1e-12) ** 2
            for level in self.floor
            for name in judged(level.errors)
        ]
        return torch.stack(ratios).amax(0).clamp_min(1e-300)
