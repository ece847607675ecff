"""Drives whose commands are drawn and heed nothing: levels of speed and steering, and coloured noise about them."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from sym2real.control import Disturbed
from sym2real.control.logged import Replayed
from sym2real.dataset import Dataset
from sym2real.experiments.excitation import ColouredNoise
from sym2real.plants import run_episode
from sym2real.protocols import Plant
from sym2real.robots import ROBOTS

ROBOT = ROBOTS["mushr"]  # whose state and actions a car has
CHANGING, ROWS = 0.6, 400  # s, of the noise; of a run
NO_LIMIT = np.array([-np.inf, np.inf])


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
        noise = ColouredNoise(np.array(deviation), CHANGING, ROBOT.dt, rng)
        drawn = Disturbed(Replayed(np.tile([steer, speed], (ROWS, 1))), noise.next, NO_LIMIT[0], NO_LIMIT[1])
        runs.append(run_episode(plant(rng), drawn, start=start, steps=ROWS, name=f"run_{run + 1}"))
    return Dataset(runs)
