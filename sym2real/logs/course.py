"""A car's heading against the way it moves: a vehicle whose tyres hold goes where it points, or straight back.

With the course c = atan2(ẏ, ẋ) of positions and a heading ψ, the length of the mean of exp(2i (c - ψ)) over the rows in
which the car moves is 1 where they turn together, whatever lies between them and whichever way it drives, and about 0
where one turns against the other, or by another amount. On a straight line it is 1 for any heading.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from sym2real.logs import derive
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING, POSITION, SPEED_COLUMN

CREEPING = 0.1  # m/s, below which a car's way has no direction
FEWEST = 40  # rows that move
# What turns together at least, and by how much one reading of a heading must be ahead of another to be told from it.
TOGETHER, AHEAD = 0.8, 0.3
APART = np.deg2rad(20.0)  # an angle between heading and course that is no tyre's slip


def course(time: Array, x: Array, y: Array, speed: Array | None = None) -> Array:
    """Direction in which a car moves, or from which it reverses, in rad ``# (rows,)``; NaN where it stands.

    Args:
        time: s ``# (rows,)``.
        x, y: m ``# (rows,)``.
        speed: as commanded, negative where it reverses; None for a car that never does ``# (rows,)``.
    """
    across, along = derive.slope(time, y), derive.slope(time, x)
    ahead = 1.0 if speed is None else np.where(speed < 0, -1.0, 1.0)
    return np.where(np.hypot(along, across) > CREEPING, np.arctan2(ahead * across, ahead * along), np.nan)


def courses(logs: Iterable[Trajectory]) -> list[Array]:
    """The way that a car moves in every log, in rad ``# (rows,)``."""
    angles = []
    for log in logs:
        speed = log.column(SPEED_COLUMN) if SPEED_COLUMN in log.layouts.action else None
        x, y = (log.column(name) for name in POSITION.columns[:2])
        angles.append(course(log.time, x, y, speed))
    return angles


def headings(logs: Iterable[Trajectory]) -> list[Array]:
    """Where it points in every log, in rad ``# (rows,)``."""
    return [np.arctan2(*(log.column(name) for name in HEADING.columns)) for log in logs]


def together(ways: Sequence[Array], yaws: Sequence[Array]) -> float:
    """How far headings in rad ``# (rows,)`` turn with courses: 1 always, 0 by chance; NaN where too little moves."""
    apart = _apart(ways, yaws)
    return float(abs(np.exp(2j * apart).mean())) if len(apart) >= FEWEST else float("nan")


def decides(best: float, other: float) -> bool:
    """Whether a reading of a heading fits so much better than another that it is the right one."""
    return best > TOGETHER and best - other > AHEAD


def between(ways: Sequence[Array], yaws: Sequence[Array]) -> float:
    """Mean angle in rad from headings to courses; 0 where slip and noise may be all of it, or nothing moves."""
    apart = _apart(ways, yaws)
    if not len(apart):
        return 0.0
    # A command that changes its sign is early: in a few rows the car still goes the other way.
    mean = 0.5 * float(np.angle(np.exp(2j * apart).mean()))
    if np.cos(apart - mean).mean() < 0:
        mean -= math.copysign(math.pi, mean)
    return mean if abs(mean) > APART else 0.0


def _apart(ways: Sequence[Array], yaws: Sequence[Array]) -> Array:
    apart = np.concatenate(ways) - np.concatenate(yaws)
    return apart[np.isfinite(apart)]
