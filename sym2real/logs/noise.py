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
    states = torch.as_tensor(trajectory.state)
    return noise_level(trajectory.layouts.state.difference(states[1:], states[:-1]).cumsum(0).numpy())


def component_noise(data: Dataset) -> Array:
    """Noise of every tangent component, median over logs ``# (tangent,)``; a few rows among longer logs show none."""
    long_enough = [trajectory for trajectory in data if len(trajectory) > FEWEST] or data
    return np.median([noise_of(trajectory) for trajectory in long_enough], axis=0)
