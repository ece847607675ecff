"""Quantities that a log does not hold and that follow from those it does.

A rate of change is the slope, at the row, of the parabola fitted by least squares to a few rows around it (fewer on
either end of a short log): on regular stamps this is the filter of A. Savitzky and M. Golay (Analytical Chemistry
36(8), 1964), and it is exact for motions of constant acceleration on any stamps.

A rate that a model predicts is smoothed over one of the model's steps to either side and no further: a step of a
command that is spread over more looks like a lag of the robot, while equations and diagnoses are fitted under noise.
What changes faster than that, and is measured so well that it shows, is smoothed over less.
"""

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real import rotation
from sym2real.trajectory import Array

SHORTEST, USUAL = 3, 5
CHI_SQUARE_MEDIAN = 0.4549  # of one degree of freedom
ONE_TURN = 2.02 * np.pi  # rad, noise at its ends included


def rows_around(time: Array, dt: float | None) -> int:
    """How many rows lie within a step of a model to either side of one, itself with them; at least three."""
    if dt is None or len(time) < 2:
        return SHORTEST
    return max(SHORTEST, 2 * round(dt / float(np.median(np.diff(time)))) + 1)


def in_force(own: Array, stamps: Array) -> NDArray[np.int64]:
    """Which of the commands with stamps ``own`` is in force halfway to the next row ``# (rows,)``; -1 before the first.

    A controller that answers a row has sent by then.
    """
    steps = np.diff(stamps)
    usual = float(np.median(steps)) if len(steps) else 0.0
    halfway = stamps + 0.5 * np.minimum(np.append(steps, usual), usual)  # not of a gap
    return np.asarray(np.searchsorted(own, halfway, side="right") - 1)


def mean_in_force(own: Array, values: Array, starts: Array, ends: Array) -> Array:
    """Mean, over stretches of time ``# (rows,)``, of a command that holds from each of its stamps ``own`` on.

    Over a stretch that begins before the first stamp, of what it holds from there on.
    """
    starts = np.maximum(starts, own[0])
    stamps = np.append(own, max(own[-1], ends[-1]))
    sums = np.concatenate([[0.0], np.cumsum(values * np.diff(stamps))])
    whole = np.interp(ends, stamps, sums) - np.interp(starts, stamps, sums)
    return np.asarray(whole / np.maximum(ends - starts, np.finfo(float).tiny))


def _windows(rows: int, around: int) -> NDArray[np.int64]:
    width = min(around, rows)
    start = np.clip(np.arange(rows) - width // 2, 0, rows - width)
    return start[:, None] + np.arange(width)  # (rows, width)


def _slope_weights(time: Array, windows: NDArray[np.int64]) -> Array:
    offset = time[windows] - time[:, None]
    scale = np.abs(offset).max(axis=1, keepdims=True).clip(min=np.finfo(float).tiny)
    powers = np.arange(min(3, windows.shape[1]))
    design = (offset / scale)[..., None] ** powers  # (rows, width, powers)
    transposed = design.swapaxes(1, 2)
    fitted = np.linalg.solve(transposed @ design, transposed)
    return np.asarray(fitted[:, min(1, len(powers) - 1)] / scale)  # (rows, width)


def slope(time: Array, values: Array, around: int = USUAL) -> Array:
    """Rate of change of ``values`` ``# (rows, ...)`` per second at each of the stamps ``# (rows,)``.

    Args:
        time: s.
        values: at these times.
        around: rows that the parabola goes through.
    """
    if len(time) < 2:
        return np.zeros_like(values)
    windows = _windows(len(time), around)
    return np.asarray(np.einsum("rw,rw...->r...", _slope_weights(time, windows), values[windows]))


def closest_slope(time: Array, values: Array, most: int) -> Array:
    """:func:`slope` through at most so many rows: as many as make the least error, of noise and of motion they lose.

    A slope through m rows to either side has σ² / (S dt²) of white noise σ, S = m (m + 1) (2 m + 1) / 3. From that
    through three it is off by noise, σ² (1/2 - 1/S) / dt², and by motion that is lost between its rows.

    Args:
        time: s ``# (rows,)``.
        values: at these times ``# (rows,)``.
        most: odd number of rows.
    """
    moved = np.abs(np.diff(values))
    if len(time) <= most or most <= SHORTEST or not moved.any():
        return slope(time, values, most)
    # Of an encoder that mostly rests at a count, third differences are zero: its noise is that of counts.
    white = max(np.median(np.diff(values, n=3) ** 2) / CHI_SQUARE_MEDIAN / 20.0, moved[moved > 0].min() ** 2 / 12.0)
    noise, nearest = float(white) / float(np.median(np.diff(time))) ** 2, slope(time, values, SHORTEST)
    errors, slopes = [], []
    for half in sorted({min(round(1.4**power), most // 2) for power in range(most)}):
        squares = half * (half + 1) * (2 * half + 1) / 3
        slopes.append(slope(time, values, 2 * half + 1))
        lost = float(np.square(slopes[-1] - nearest).mean()) - noise * (0.5 - 1.0 / squares)
        errors.append(noise / squares + max(lost, 0.0))
    return slopes[int(np.argmin(errors))]


def rolling(time: Array, position: Array, yaw: Array, wheel: Array, around: int) -> Array:
    """World velocity ``# (rows, 2)`` of a car, m/s: along the heading its wheels' speed, across it the path's slope.

    A wheel whose speed has no direction (no value below zero) turns backwards where the path does.

    Args:
        time: s ``# (rows,)``.
        position: m ``# (rows, 2)``.
        yaw: rad ``# (rows,)``.
        wheel: m/s ``# (rows,)``.
        around: rows that the path's slope is taken over.
    """
    ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    path = slope(time, position, around)
    forward = np.sum(path * ahead, axis=1)
    if wheel.min() >= 0.0:
        # Half of its speed: noise of a path at rest changes no sign.
        wheel = np.where(forward < -0.5 * wheel, -wheel, wheel)
    across = np.sum(path * left, axis=1)
    return np.asarray(wheel[:, None] * ahead + across[:, None] * left)


def body_rate(time: Array, quaternion: Array, around: int = USUAL) -> Array:
    """Angular velocity in body axes, rad/s ``# (rows, 3)``, of attitudes w x y z, body→world ``# (rows, 4)``."""
    if len(time) < 2:
        return np.zeros((len(time), 3))
    windows = _windows(len(time), around)
    here = torch.from_numpy(quaternion)
    turn = rotation.logarithm(rotation.multiply(rotation.conjugate(here[:, None]), here[torch.from_numpy(windows)]))
    return np.asarray(np.einsum("rw,rwk->rk", _slope_weights(time, windows), turn.numpy()))


def continuous(quaternion: Array) -> Array:
    """The same attitudes ``# (rows, 4)`` with signs such that neighbours are near; the first has w ≥ 0."""
    steps = np.sign(np.sum(quaternion[1:] * quaternion[:-1], axis=1))
    first = -1.0 if quaternion[0, 0] < 0 else 1.0
    signs = first * np.concatenate([[1.0], np.cumprod(np.where(steps < 0, -1.0, 1.0))])
    return quaternion * signs[:, None]


def counted_heading(sine: Array, cosine: Array) -> Array:
    """A heading in rad ``# (rows,)`` that counts on beyond a turn."""
    return np.unwrap(np.arctan2(sine, cosine))


def counted_angles(time: Array, quaternion: Array, rates: Array) -> Array:
    """Roll, pitch and yaw in rad ``# (rows, 3)``, or yaw alone ``# (rows, 1)``, that count on beyond a turn.

    Each is the one nearest to the last angle and the turn since, of both triples that are one attitude, (φ, θ, ψ) and
    (φ + π, π - θ, ψ + π): that holds of angles that turn by more than half a turn from row to row. Roll and pitch are
    level on average, within half a turn.

    Args:
        time: s ``# (rows,)``.
        quaternion: attitudes w x y z ``# (rows, 4)``.
        rates: of the angles in rad/s, about all axes or about the vertical ``# (rows, 3 or 1)``.
    """
    angles = rotation.to_euler(torch.from_numpy(quaternion)).numpy()[:, -rates.shape[1] :]
    counted, turns = [angles[0]], 0.5 * (rates[1:] + rates[:-1]) * np.diff(time)[:, None]
    for logged, turn in zip(angles[1:], turns, strict=True):
        near = counted[-1] + turn
        readings = [reading + 2.0 * np.pi * np.round((near - reading) / (2.0 * np.pi)) for reading in _alike(logged)]
        counted.append(min(readings, key=lambda reading: float(np.abs(reading - near).sum())))
    whole = min(_alike(np.stack(counted)), key=lambda reading: float(np.square(np.diff(reading, axis=0) - turns).sum()))
    whole[:, :-1] -= 2.0 * np.pi * np.round(whole[:, :-1].mean(0) / (2.0 * np.pi))
    return whole


def _alike(angles: Array) -> list[Array]:
    """Both readings of one attitude ``# (..., 3)``; of a yaw alone there is one."""
    return [angles] if angles.shape[-1] == 1 else [angles, angles * np.array([1.0, -1.0, 1.0]) + np.pi]


def unwrapped(angle: Array) -> Array:
    """An angle in rad ``# (rows,)`` without an encoder's jumps by whole turns; other jumps stay as they are.

    A jump is one of whole turns where what is left of it is at most twice the largest of all other steps. Where those
    are no smaller than a quarter turn, that holds of any step, such as of an angle that is in degrees: it is unwrapped
    only if it stays within a turn, as what begins anew does.
    """
    steps = np.diff(angle)
    turns = np.round(steps / (2.0 * np.pi))
    usual = np.abs(steps[turns == 0]).max(initial=0.0)
    if usual >= 0.5 * np.pi and np.ptp(angle) > ONE_TURN:
        return angle
    turns[np.abs(steps - 2.0 * np.pi * turns) > 2.0 * usual] = 0.0
    return angle - 2.0 * np.pi * np.concatenate([[0.0], np.cumsum(turns)])


def heading(quaternion: Array) -> Array:
    """Yaw in rad ``# (rows,)`` of attitudes w x y z ``# (rows, 4)``."""
    return rotation.yaw(torch.from_numpy(quaternion)).numpy()


def about_vertical(yaw: Array) -> Array:
    """Attitudes w x y z ``# (rows, 4)`` of a yaw in rad ``# (rows,)``, level."""
    zero = np.zeros(len(yaw))
    return np.stack([np.cos(yaw / 2.0), zero, zero, np.sin(yaw / 2.0)], axis=1)


def from_euler(angles: Array) -> Array:
    """Attitudes w x y z ``# (rows, 4)`` of roll, pitch, yaw in rad ``# (rows, 3)``."""
    return rotation.from_euler(*torch.from_numpy(angles).unbind(-1)).numpy()


def to_world(quaternion: Array, vectors: Array) -> Array:
    """Body vectors ``# (rows, 3)`` in world axes, for attitudes w x y z ``# (rows, 4)``."""
    return rotation.rotate(torch.from_numpy(quaternion), torch.from_numpy(vectors)).numpy()


def up(quaternion: Array) -> Array:
    """Body z axis in the world ``# (rows, 3)``, for attitudes w x y z ``# (rows, 4)``."""
    return to_world(quaternion, np.tile([0.0, 0.0, 1.0], (len(quaternion), 1)))
