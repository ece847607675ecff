"""Drives whose commands are drawn and heed nothing: levels of speed and steering, and coloured noise about them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from sym2real.dataset import Dataset
from sym2real.experiments.excitation import ColouredNoise
from sym2real.plants import run_episode
from sym2real.protocols import Memoryless, Plant
from sym2real.robots import ROBOTS
from sym2real.trajectory import Array

ROBOT = ROBOTS["mushr"]  # whose state and actions a car has
CHANGING, ROWS = 0.6, 400  # s, of the noise; of a run


@dataclass
class Drawn(Memoryless):
    """A controller that sends what is drawn.

    Args:
        level: mean of the commands ``# (action,)``.
        noise: about it.
    """

    level: Array
    noise: ColouredNoise

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """The next action ``# (action,)``."""
        action: Array = self.level + self.noise.next()
        return action


def drawn_drives(
    plant: Callable[[np.random.Generator], Plant],
    speeds: Sequence[float],
    steering: Sequence[float],
    deviation: Sequence[float],
    seed: int,
) -> Dataset:
    """Runs at every level of speed in m/s, with every level of steering in rad.

    Args:
        plant: made anew for every run, with the generator of its noise.
        speeds, steering: levels.
        deviation: of steering and speed about them.
        seed: of all runs.
    """
    runs = []
    for run, (speed, steer) in enumerate(product(speeds, steering)):
        rng = np.random.default_rng([seed, run])
        start = np.array([0.0, 0.0, 0.0, 1.0, speed, 0.0, 0.0])
        drawn = Drawn(np.array([steer, speed]), ColouredNoise(np.array(deviation), CHANGING, ROBOT.dt, rng))
        runs.append(run_episode(plant(rng), drawn, start=start, steps=ROWS, name=f"run_{run + 1}"))
    return Dataset(runs)
