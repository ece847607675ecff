"""What a disturbance may depend on (time, place, motion, commands), and how much of a robot's motion it makes.

By how far it moves the robot, that is, beside how far the robot moves. Both are second differences over a segment, its
end and its start less twice its middle: going on as before is no motion. Logs with little noise show disturbances that
no prediction needs: the integration error of the simulator that wrote them, for one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.estimate.whitening import PIECES, Spread
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.logs.conditions import signed_features
from sym2real.trajectory import Array


def features_of(problem: Problem) -> tuple[list[str], tuple[Array, ...]]:
    """Names, and means over the piece before every piece, itself, and the one behind ``# (S·pieces, features)``."""
    segments = problem.segments
    tables = [signed_features(trajectory) for trajectory in problem.data]
    names = list(tables[0])
    columns = [np.stack([table[name] for name in names], axis=1) for table in tables]
    pieces = [
        (columns[log], row + first, row + last)
        for log, row in zip(segments.log, segments.row, strict=True)
        for first, last in pairwise(segments.edges(PIECES))
    ]
    return names, tuple(np.stack([_mean(*piece, move) for piece in pieces]) for move in (-1, 0, 1))


def _mean(column: Array, first: int, last: int, move: int) -> Array:
    """Over rows from first to before last, moved by so many times their number as far as there are rows ``# (F,)``."""
    away = np.clip(move * (last - first), -first, len(column) - last)
    return np.asarray(column[first + away : last + away].mean(axis=0))


def within(columns: Array, log: NDArray[np.int64]) -> Array:
    """Columns ``# (pieces, columns)`` less their mean over every log."""
    _, place = np.unique(log, return_inverse=True)
    means = np.stack([columns[place == index].mean(axis=0) for index in range(place.max() + 1)])
    return np.asarray(columns - means[place])


def part_of_disturbance(segments: Segments, spread: Spread, name: str, disturbance: Array | float) -> float:
    """Largest part of any field's motion that a disturbance makes.

    Args:
        segments: of the logs.
        spread: shapes of the disturbances.
        name: of this one.
        disturbance: over every piece ``# (S·pieces,)``, or the same everywhere, in its unit.
    """
    place = spread.names.index(name)
    pieces = torch.as_tensor(disturbance, dtype=torch.float64).expand(len(segments) * PIECES) / spread.sizes[place]
    changes = torch.einsum("srp,sp->sr", spread.disturbances[:, :, place], pieces.reshape(-1, PIECES))
    return part_of_changes(segments, changes)


def part_of_changes(segments: Segments, changes: Tensor) -> float:
    """The same of what changes in segments ``# (S, N·C)``."""
    paths, middle = changes.unflatten(1, (segments.length, -1)), (segments.length - 1) // 2
    moved = paths[:, -1] - 2 * paths[:, middle] + paths[:, 0]
    motion = _motion(segments, middle)
    fields = torch.tensor(segments.channel)
    return max(_size(moved[:, fields == field]) / _size(motion[:, fields == field]) for field in fields.unique())


def _motion(segments: Segments, middle: int) -> Tensor:
    """Of what was measured ``# (S, C)``."""
    layout = segments.layout
    first, centre, last = (segments.measured[:, row] for row in (0, middle, -1))
    return (layout.difference(last, centre) - layout.difference(centre, first))[:, list(segments.compared)]


def _size(moved: Tensor) -> float:
    """Root mean square of norms ``# (S, ·)``."""
    return max(float(moved.square().sum(1).mean().sqrt()), 1e-12)
