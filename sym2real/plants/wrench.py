"""Random wrenches: they vary smoothly in time, from which a base model learns its wrench inputs."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from sym2real.robots import Robot
from sym2real.trajectory import Array
from sym2real.vocabulary import FORCE, TORQUE, WRENCH

CORRELATION = 0.3  # s


def random_wrench(robot: Robot, steps: int, rng: np.random.Generator) -> Array:
    """A sequence of wrenches ``# (steps, inputs)`` for :func:`~sym2real.plants.run_episode`.

    Gaussian noise of a correlation time of 0.3 s, squashed so that the size of the force, that of the torque
    measured in each axis' limit, and every force along a joint stay within ``robot.limits.push``.
    """
    columns = robot.layouts.inputs.columns
    width = CORRELATION / robot.dt
    margin = int(np.ceil(4.0 * width))
    noise = gaussian_filter1d(rng.standard_normal((steps + 2 * margin, len(columns))), width, axis=0)
    # A Gaussian filter of this width shrinks white noise to a standard deviation of (2 √π width)^(-1/2).
    smooth = noise[margin : margin + steps] * np.sqrt(2.0 * np.sqrt(np.pi) * width)
    together = [[column for column in columns if column in field.columns] for field in (FORCE, TORQUE)]
    for names in (*together, *([column] for column in columns if column not in WRENCH)):
        group = [columns.index(name) for name in names]
        size = np.linalg.norm(smooth[:, group], axis=1, keepdims=True)
        smooth[:, group] /= np.sqrt(1.0 + size**2)
    wrench: Array = smooth * [robot.limits.push[column] for column in columns]
    return wrench
