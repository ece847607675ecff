"""Rows in which a robot stands: they say nothing of how it moves, and many of them make what moves look odd.

With rotors it stands on something, which carries it: no flight, whatever its model lacks. Who pushes with less than
half of what carries it falls with more than half of gravity, or stands. What is usual the log itself tells, so that a
wrong mass, thrust map or unit of thrust changes nothing. On its way up and down it stands as long as it is no higher.

On wheels it stands where it is commanded to and does, but for a moment before it goes and after it came.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sym2real.layout import motors_of
from sym2real.logs.dropouts import LEFT_OUT
from sym2real.logs.units import GRAVITY
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEIGHT, POSITION, THRUST

LEVEL = POSITION.columns[:2]
WEAK = 0.5  # of the usual thrust
FALLING = 0.25  # of gravity
LEAST, FEWEST = 0.2, 5  # s of little thrust, in which it falls 0.1 m at half of gravity; rows for a parabola
LIFTED = 0.03  # m above where it stands
REST, BESIDE = 1.0, 0.5  # s of rest that are left out at least; s of it that stay, before it goes and after it came
AWAY = 0.03  # m from where it rests
STILL = 1e-3  # of the largest commanded speed

Rows = NDArray[np.bool_]


def in_motion(log: Trajectory) -> list[Trajectory]:
    """The stretches of a log in which it flies or drives; the log itself where nobody can tell."""
    if (thrust := _thrust(log)) is not None and HEIGHT in log.layouts.state:
        standing, why = _landed(thrust, log.column(HEIGHT), log.dt), "with little of its usual thrust it does not fall"
    elif (speed := _drive(log)) is not None:
        standing, why = _resting(speed, np.stack([log.column(axis) for axis in LEVEL], axis=1), log.dt), "as commanded"
    else:
        return [log]
    moving = stretches(~standing)
    if not standing.any() or not moving:
        return [log]
    where = ", ".join(f"{start + 1} to {stop}" for start, stop in stretches(standing))
    names = [log.name if len(moving) == 1 else f"{log.name}#{number}" for number in range(1, len(moving) + 1)]
    pieces = [replace(log.rows(*rows), name=name) for rows, name in zip(moving, names, strict=True)]
    return [replace(pieces[0], notes=(*log.notes, f"{LEFT_OUT}, in which it stands ({why}): {where}")), *pieces[1:]]


def _thrust(log: Trajectory) -> Array | None:
    """What the rotors are commanded ``# (rows,)``, in any unit; None where they are not."""
    commands = motors_of(log.layouts.action) or tuple(name for name in log.layouts.action if name in THRUST.columns)
    return log.action[:, log.layouts.action.indices(commands)].mean(axis=1) if commands and len(log) > 1 else None


def _drive(log: Trajectory) -> Array | None:
    """The largest commanded speed of its wheels ``# (rows,)``, in any unit; None where there is none."""
    units = log.layouts.action.units
    commands = log.layouts.action.indices(name for name, unit in units.items() if unit in {"m/s", "rad/s"})
    planar = {*LEVEL} <= {*log.layouts.state} and HEIGHT not in log.layouts.state
    return np.abs(log.action[:, commands]).max(axis=1) if commands and planar and len(log) > 1 else None


def _resting(speed: Array, place: Array, dt: float) -> Rows:
    resting, beside = np.zeros(len(speed), dtype=bool), round(BESIDE / dt)
    for start, stop in stretches(speed <= STILL * speed.max()):
        away = np.linalg.norm(place[start:stop] - np.median(place[(start + stop) // 2 : stop], axis=0), axis=1) > AWAY
        first = start + int(np.max(np.flatnonzero(away), initial=-1)) + 1
        first, last = first + beside * (first > 0), stop - beside * (stop < len(speed))
        resting[first:last] = (last - first) * dt >= REST
    return resting


def _landed(thrust: Array, height: Array, dt: float) -> Rows:
    usual = thrust[thrust >= WEAK * np.percentile(thrust, 95)].mean()
    standing, least = np.zeros(len(thrust), dtype=bool), max(round(LEAST / dt), FEWEST)
    for start, stop in stretches(thrust < WEAK * usual):
        for long in (least, 4 * least):  # who is dropped falls first, and stands then; a rough height needs more rows
            parts = ((first, first + long) for first in range(start, stop - long + 1, long))
            if still := [(first, last) for first, last in parts if not _falls(height[first:last], dt)]:
                break
        for first, last in still:
            standing[first:last] = True
            for lowest, highest in stretches(height < np.median(height[first:last]) + LIFTED):
                standing[lowest:highest] |= lowest < last and first < highest
    return standing


def _falls(height: Array, dt: float) -> bool:
    """Whether it accelerates downwards, or noise hides whether it does: by a parabola."""
    (half, *_), covariance = np.polyfit(dt * np.arange(len(height)), height, 2, cov=True)  # of the acceleration
    return bool(2.0 * (half - 2.0 * np.sqrt(covariance[0, 0])) < -FALLING * GRAVITY)


def stretches(rows: Rows) -> list[tuple[int, int]]:
    """First row and the row after the last of every stretch of true ones."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]
