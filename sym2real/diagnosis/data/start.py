"""Where a prediction window starts: the state estimated from the rows up to its first, never from rows inside it.

Position and velocity share one local polynomial of constant acceleration or, where that does not fit, constant jerk;
every other quantity has a local line or parabola of its own. They are fitted by least squares to the last
:data:`ROWS` rows, weighted by the noise that third differences show. Where neither fits within that noise (a step in
a command a moment ago), the measured row is better than a fit and is taken.
"""

from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real.diagnosis.settings import SETTINGS
from sym2real.logs.noise import noise_of
from sym2real.trajectory import Array, Trajectory

Start = Literal["smoothed", "measured"]

ROWS = 10
# Ages of rows that differ by less than this part of the largest are one.
ALIKE = 1e-9


def start_states(trajectory: Trajectory, starts: NDArray[np.int64], method: Start = "smoothed") -> Array:
    """States from which windows start ``# (windows, state)``.

    Args:
        trajectory: the log.
        starts: rows at which windows start ``# (windows,)``.
        method: "smoothed" uses the last :data:`ROWS` rows up to and including the start row, where there are as many,
            "measured" that row alone.
    """
    begun, full = trajectory.state[starts], (starts >= ROWS - 1) & (method == "smoothed")
    if full.any():
        begun[full] = _smoothed(trajectory, starts[full])
    return begun


def _smoothed(trajectory: Trajectory, starts: NDArray[np.int64]) -> Array:
    history = starts[:, None] + np.arange(1 - ROWS, 1)  # (windows, ROWS)
    states = torch.as_tensor(trajectory.state)
    layout = trajectory.layouts.state
    away = layout.difference(states[history], states[starts][:, None]).numpy()  # (windows, ROWS, tangent)
    noise = noise_of(trajectory)
    ages = trajectory.time[history] - trajectory.time[starts][:, None]
    correction = np.zeros(away.shape[::2])  # (windows, tangent)
    paired = [[layout.vector_places[name] for name in names] for names in (layout.rates, layout.rates.values())]
    if layout.rates:
        speed = np.stack([trajectory.column(column)[starts] for column in layout.rates.values()])
        position, velocity = (away[:, :, part].transpose(2, 0, 1) for part in paired)  # (pairs, windows, ROWS)
        correction[:, paired] = _joint_fit(position, velocity, speed[..., None], noise[paired], ages).transpose(1, 2, 0)
    others = sorted(set(range(layout.tangent_size)) - {slot for part in paired for slot in part})
    correction[:, others] = _single_fit(away[:, :, others].transpose(2, 0, 1), noise[others], ages).T
    return layout.retract(states[starts], torch.as_tensor(correction)).numpy()


def _joint_fit(position: Array, velocity: Array, speed: Array, noise: Array, ages: Array) -> Array:
    """Position and velocity corrections at age zero ``# (pairs, windows, 2)`` of p₀ + v₀τ + aτ²/2 + jτ³/6.

    Args:
        position, velocity: differences from the start row ``# (pairs, windows, ROWS)``.
        speed: the start row's measured velocity ``# (pairs, windows, 1)``.
        noise: of both ``# (2, pairs)``.
        ages: of the rows ``# (windows, ROWS)``.
    """
    of_positions, of_velocities = noise[:, :, None, None]
    target = np.concatenate([(position - speed * ages) / of_positions, velocity / of_velocities], axis=-1)
    ages = _of_all(ages)
    unit, zero = np.ones_like(ages), np.zeros_like(ages)
    of_position = np.stack([unit, ages, ages**2 / 2, ages**3 / 6], axis=-1) / of_positions[..., None]
    of_velocity = np.stack([zero, unit, ages, ages**2 / 2], axis=-1) / of_velocities[..., None]
    return _simplest_adequate(np.concatenate([of_position, of_velocity], axis=-2), target, (3, 4))[..., :2]


def _single_fit(values: Array, noise: Array, ages: Array) -> Array:
    """Correction at age zero ``# (columns, windows)`` of a line or parabola through ``# (columns, windows, ROWS)``."""
    ages = _of_all(ages)
    design = np.stack([np.ones_like(ages), ages, ages**2], axis=-1) / noise[:, None, None, None]
    return _simplest_adequate(design, values / noise[:, None, None], (2, 3))[..., 0]


def _of_all(ages: Array) -> Array:
    """Ages of the rows of every window ``# (windows, ROWS)``; of one that stands for all where sampling is even."""
    return ages[:1] if bool((np.ptp(ages, axis=0) <= ALIKE * np.abs(ages).max()).all()) else ages


def _simplest_adequate(design: Array, target: Array, sizes: tuple[int, ...]) -> Array:
    """Least squares with the first so many columns, the fewest whose residuals are noise; zero where none are.

    Args:
        design: broadcast over windows where they share one ``# (..., rows, columns)``.
        target: ``# (..., rows)``.
        sizes: numbers of columns, rising.

    Returns:
        Parameters that every size has ``# (..., sizes[0])``.
    """
    chosen = np.zeros((*target.shape[:-1], sizes[0]))
    waiting = np.ones(target.shape[:-1], dtype=bool)
    for size in sizes:
        part = design[..., :size]
        orthogonal, upper = np.linalg.qr(part)
        solution = np.linalg.solve(upper, orthogonal.swapaxes(-1, -2) @ target[..., None])
        residual = target - (part @ solution)[..., 0]
        spread = np.sqrt((residual**2).sum(axis=-1) / (target.shape[-1] - size))
        fits = waiting & (spread <= SETTINGS.above_noise)
        chosen[fits] = solution[fits, : sizes[0], 0]
        waiting &= ~fits
    return chosen
