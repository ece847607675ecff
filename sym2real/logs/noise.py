"""White noise of a log's columns, by third differences, which smooth motion hardly has."""

import math

import numpy as np
import torch

from sym2real.dataset import Dataset
from sym2real.trajectory import Array, Trajectory

# Median absolute deviation of a normal variable to its standard deviation.
MAD_TO_SIGMA = 1.4826
SMALLEST_NOISE = 1e-9
FEWEST = 10  # rows of a log that shows a noise
APART = 4  # rows over which noise is held against that of single steps


def noise_level(values: Array, order: int = 3) -> Array:
    """Standard deviation of white noise on smooth columns ``# (rows, k) -> (k,)``, from differences of this order.

    Source: P. Hall, J. Kay, D. Titterington, difference-based variance estimation, Biometrika 77 (1990) 521–528, with
    the binomial sequence of the order and a median for robustness against steps.
    """
    differences = np.diff(values, n=order, axis=0)
    spread = np.median(np.abs(differences - np.median(differences, axis=0)), axis=0)
    gain = np.sqrt(math.comb(2 * order, order))
    return np.asarray(np.maximum(MAD_TO_SIGMA * spread / gain, SMALLEST_NOISE))


def noise_of(trajectory: Trajectory) -> Array:
    """The same of a log's states, per tangent component ``# (tangent,)``: of the steps between rows, added up."""
    return noise_level(_path(trajectory))


def component_noise(data: Dataset) -> Array:
    """Noise of every tangent component, median over logs ``# (tangent,)``; a few rows among longer logs show none."""
    return np.asarray(np.median([noise_of(trajectory) for trajectory in _longer(data, FEWEST)], axis=0))


def growth(data: Dataset, rows: int) -> Array:
    """Times as large as over one row the variance of third differences over so many rows is ``# (tangent,)``.

    White noise has 1, a random walk as many as there are rows, and smooth motion their sixth power.
    """
    times = []
    for path in map(_path, _longer(data, APART * FEWEST)):
        apart = np.mean([noise_level(path[first::rows]) for first in range(rows)], axis=0)
        times.append((apart / noise_level(path)) ** 2)
    return np.asarray(np.median(times, axis=0))


def _path(trajectory: Trajectory) -> Array:
    states = torch.as_tensor(trajectory.state)
    return np.asarray(trajectory.layouts.state.difference(states[1:], states[:-1]).cumsum(0))


def _longer(data: Dataset, rows: int) -> Dataset | list[Trajectory]:
    return [trajectory for trajectory in data if len(trajectory) > rows] or data
