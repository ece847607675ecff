"""Flights and drives out of the distribution that base models are trained on.

A quadrotor flies radius 0.9–1.3 m at 2.3–2.9 rad/s with noise doubled, and tumbles on random rates from 8 m; a car
drives in reverse, or at 2.2–4 m/s.
"""

import numpy as np

from sym2real.dataset import Dataset
from sym2real.experiments.excitation import RandomRates, unlimited
from sym2real.experiments.flights import SPEED_LIMIT, Draw, Setting, Style, around, circle, eight, runs, tilted
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot

FAST = Style(noise=2.0, tilt=0.6, height=3.0, radius=(0.9, 1.3), rate=(2.3, 2.9))


def wild_flights(count: int, seed: int, *, steps: int = 400) -> Dataset:
    """Faster, steeper and tumbling."""
    kinds = (_fast_circle, _tumble, _fast_eight, _tumble)
    return runs(CRAZYFLIE, MujocoPlant(CRAZYFLIE), kinds, count, seed, steps=steps)


def wild_drives(count: int, seed: int, *, steps: int = 400) -> Dataset:
    """In reverse, or fast."""
    return _drives((_reverse, _fast_round), count, seed, steps)


def reverse_drives(count: int, seed: int, *, steps: int = 400) -> Dataset:
    """In reverse alone, which has a bar of its own."""
    return _drives((_reverse,), count, seed, steps)


def _drives(kinds: tuple[Draw, ...], count: int, seed: int, steps: int) -> Dataset:
    return runs(MUSHR, MujocoPlant(unlimited(MUSHR)), kinds, count, seed, steps=steps)


def _fast_circle(robot: Robot, rng: np.random.Generator) -> Setting:
    return circle(robot, rng, FAST)


def _fast_eight(robot: Robot, rng: np.random.Generator) -> Setting:
    return eight(robot, rng, FAST)


def _tumble(robot: Robot, rng: np.random.Generator) -> Setting:
    return RandomRates(robot, rng), tilted(robot, rng, FAST.tilt, np.array([0.0, 0.0, 8.0]))


def _reverse(robot: Robot, rng: np.random.Generator) -> Setting:
    radius, speed = rng.uniform(1.0, 2.0), rng.uniform(0.8, 1.6)
    return around(robot, rng, "reverse_circle", radius=radius, speed=speed, fastest=SPEED_LIMIT)


def _fast_round(robot: Robot, rng: np.random.Generator) -> Setting:
    speed = rng.uniform(2.2, 4.0)
    return around(robot, rng, "circle", radius=rng.uniform(2.0, 4.0), speed=speed, fastest=1.2 * speed)
