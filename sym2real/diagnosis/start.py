"""Where a prediction window starts: the state estimated from the rows up to its first, never from rows inside it.

Position and velocity share one local polynomial of constant acceleration or, where that does not fit, constant jerk;
every other quantity has a local line or parabola of its own. They are fitted by least squares to the last
:data:`ROWS` rows, weighted by the noise that third differences show. Where neither fits within that noise (a step in
a command a moment ago), the measured row is better than a fit and is taken.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real.layout import Layout
from sym2real.trajectory import Array, Trajectory

Start = Literal["smoothed", "measured"]

ROWS = 10
# Residuals of an adequate fit scatter by the noise itself; beyond this factor the fit is wrong, not noisy.
ADEQUATE = 1.3
# Median absolute deviation of a normal variable to its standard deviation, and the gain of a third difference.
MAD_TO_SIGMA = 1.4826
THIRD_DIFFERENCE_GAIN = np.sqrt(20.0)
SMALLEST_NOISE = 1e-9
# Designs whose entries differ by less than this part of the largest are one.
ALIKE = 1e-9


def noise_level(values: Array) -> Array:
    """Standard deviation of white noise on smooth columns ``# (rows, k) -> (k,)``, from third differences.

    Source: J. Hall et al., difference-based variance estimation, Biometrika 77 (1990) 521–528, with the binomial
    sequence of order three and a median for robustness against steps.
    """
    third = np.diff(values, n=3, axis=0)
    spread = np.median(np.abs(third - np.median(third, axis=0)), axis=0)
    noise: Array = np.maximum(MAD_TO_SIGMA * spread / THIRD_DIFFERENCE_GAIN, SMALLEST_NOISE)
    return noise


def start_states(trajectory: Trajectory, starts: NDArray[np.int64], method: Start = "smoothed") -> Array:
    """States from which windows start ``# (windows, state)``.

    Args:
        trajectory: the log.
        starts: rows at which windows start, each at least ``ROWS - 1`` ``# (windows,)``.
        method: "smoothed" uses the rows up to and including the start row, "measured" that row alone.
    """
    measured = trajectory.state[starts]
    if method == "measured":
        return measured
    history = starts[:, None] + np.arange(1 - ROWS, 1)  # (windows, ROWS)
    states = torch.as_tensor(trajectory.state)
    layout = trajectory.layouts.state
    tangents = layout.difference(states[history], states[starts][:, None]).numpy()  # (windows, ROWS, tangent)
    steps = layout.difference(states[1:], states[:-1]).cumsum(0).numpy()  # (rows - 1, tangent)
    noise = noise_level(steps)
    ages = trajectory.time[history] - trajectory.time[starts][:, None]
    correction = np.zeros(tangents.shape[::2])  # (windows, tangent)
    slots = _tangent_slots(layout)
    paired = [(slots[p], slots[v], v) for p, v in _position_velocity_pairs(layout)]
    for position, velocity, column in paired:
        speed = trajectory.column(column)[starts][:, None]
        correction[:, [position, velocity]] = _joint_fit(
            tangents[:, :, position], tangents[:, :, velocity], speed, noise[[position, velocity]], ages
        )
    taken = {slot for pair in paired for slot in pair[:2]}
    for slot in sorted(set(range(layout.tangent_size)) - taken):
        correction[:, slot] = _single_fit(tangents[:, :, slot], float(noise[slot]), ages)
    return layout.retract(states[starts], torch.as_tensor(correction)).numpy()


def _tangent_slots(layout: Layout) -> dict[str, int]:
    """Tangent position of every column of a vector field."""
    slots: dict[str, int] = {}
    position = 0
    for field in layout.fields:
        if field.kind == "vector":
            slots.update({column: position + i for i, column in enumerate(field.columns)})
        position += field.tangent_size
    return slots


def _position_velocity_pairs(layout: Layout) -> list[tuple[str, str]]:
    columns = [column for field in layout.fields if field.name == "position" for column in field.columns]
    return [(column, f"v{column}") for column in columns if f"v{column}" in layout]


def _joint_fit(position: Array, velocity: Array, speed: Array, noise: Array, ages: Array) -> Array:
    """Position and velocity corrections at age zero ``# (windows, 2)`` of p₀ + v₀τ + aτ²/2 + jτ³/6.

    ``position`` and ``velocity`` are differences from the start row, whose measured velocity is ``speed``.
    """
    one, zero = np.ones_like(ages), np.zeros_like(ages)
    of_position = np.stack([one, ages, ages**2 / 2, ages**3 / 6], axis=-1) / noise[0]  # (windows, ROWS, 4)
    of_velocity = np.stack([zero, one, ages, ages**2 / 2], axis=-1) / noise[1]
    design = np.concatenate([of_position, of_velocity], axis=1)
    target = np.concatenate([(position - speed * ages) / noise[0], velocity / noise[1]], axis=1)
    return _simplest_adequate(design, target, (3, 4))[:, :2]


def _single_fit(values: Array, noise: float, ages: Array) -> Array:
    design = np.stack([np.ones_like(ages), ages, ages**2], axis=-1) / noise
    solution: Array = _simplest_adequate(design, values / noise, (2, 3))[:, 0]
    return solution


def _simplest_adequate(design: Array, target: Array, sizes: tuple[int, ...]) -> Array:
    """Least squares per window with the first so many columns, the fewest whose residuals are noise; zero else."""
    chosen = np.zeros((len(design), sizes[0]))  # (windows, parameters that every size has)
    open_windows = np.ones(len(design), dtype=bool)
    alike = bool((np.ptp(design, axis=0) <= ALIKE * np.abs(design).max()).all())  # evenly sampled: one design
    for size in sizes:
        part = design[:1, :, :size] if alike else design[:, :, :size]
        inverse = np.broadcast_to(np.linalg.pinv(part), (len(target), size, target.shape[1]))
        solution = np.einsum("wpr,wr->wp", inverse, target)
        residual = target - np.einsum("wrp,wp->wr", design[:, :, :size], solution)
        spread = np.sqrt((residual**2).sum(axis=1) / (design.shape[1] - size))
        fits = open_windows & (spread <= ADEQUATE)
        chosen[fits] = solution[fits, : sizes[0]]
        open_windows &= ~fits
    return chosen
