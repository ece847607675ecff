"""Errors over the rounds of an adaptation, by seed and evaluation episode, and how two of them compare."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from sym2real.experiments.study.sweep import Record
from sym2real.trajectory import Array

LAST = 3  # rounds whose mean is the final value
CONVERGED = 1.1
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Curve:
    """What a contestant reached on a case.

    Args:
        errors: mean position error of the evaluation episodes in m ``# (seeds, rounds + 1, episodes)``.
        costs: their mean running cost, alike.
        crashes: of them, and of the episode that was learned from ``# (seeds, rounds + 1)``.
    """

    errors: Array
    costs: Array
    crashes: Array

    @property
    def zero_shot(self) -> Array:
        """Errors of the model that was given ``# (seeds, episodes)``."""
        return self.after(0)

    @property
    def final(self) -> Array:
        """Errors of the last three rounds' models in the mean ``# (seeds, episodes)``."""
        last: Array = self.errors[:, -LAST:].mean(axis=1)
        return last

    @property
    def rounds(self) -> int:
        """Trajectories that the last model was learned from."""
        return int(self.errors.shape[1]) - 1

    def after(self, trajectories: int) -> Array:
        """Errors of the model that was learned from so many trajectories ``# (seeds, episodes)``."""
        return self.errors[:, trajectories]

    @property
    def trajectories(self) -> int:
        """The fewest after which the mean error is within a tenth of the final one."""
        mean = self.errors.mean(axis=(0, 2))
        return int(np.argmax(mean <= CONVERGED * self.final.mean()))


@dataclass(frozen=True)
class Ratio:
    """Quotient of two mean errors with its 95 % interval over seeds; the interval of a single seed is unbounded."""

    value: float
    low: float = 0.0
    high: float = math.inf

    def __str__(self) -> str:
        return f"{self.value:.2f}" + (f" ({self.low:.2f} to {self.high:.2f})" if math.isfinite(self.high) else "")

    def undecided(self, bar: float) -> bool:
        """Whether the interval holds the bar."""
        return self.low <= bar <= self.high


def ratio(above: Array, below: Array) -> Ratio:
    """How errors compare: geometric mean over seeds, and Student's interval of its logarithm.

    Args:
        above, below: errors ``# (seeds, episodes)``, paired, or of something that has no seed ``# (episodes,)``.
    """
    above, below = np.broadcast_arrays(above, below)
    logs = np.log(above.mean(axis=1) / below.mean(axis=1))
    if len(logs) < 2:
        return Ratio(float(np.exp(logs.mean())))
    half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, len(logs) - 1)) * logs.std(ddof=1) / math.sqrt(len(logs))
    return Ratio(*(float(np.exp(logs.mean() + sign * half)) for sign in (0, -1, 1)))


def curve_of(records: Mapping[str, Record], case: str, contestant: str, seeds: Sequence[int]) -> Curve | None:
    """The answers of a contestant on a case, of the seeds that are there; None without any."""
    names = [f"{case}_{contestant}_{seed}" for seed in seeds]
    rounds = [records[name]["rounds"] for name in names if name in records]
    if not rounds:
        return None
    errors, costs = (np.array([[row[key] for row in run] for run in rounds]) for key in ("errors", "costs"))
    crashes = np.array([[row["crashes"] + row["crashed"] for row in run] for run in rounds], dtype=np.float64)
    return Curve(errors, costs, crashes)
