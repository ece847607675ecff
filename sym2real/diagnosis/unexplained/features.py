"""What a disturbance may depend on (time, place, motion, commands), and how much of a robot's motion it makes.

By how far it moves the robot, that is, beside how far the robot moves. Both are second differences over a segment, its
end and its start less twice its middle: going on as before is no motion. Logs with little noise show disturbances that
no prediction needs: the integration error of the simulator that wrote them, for one.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.estimate.whitening import PIECES
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.logs import derive
from sym2real.logs.conditions import signed_features
from sym2real.logs.pose import attitudes
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE

# Of pieces: itself, the one behind, and the one before, so that each may be found by its number.
MOVES = (0, 1, -1)


def features_of(problem: Problem) -> tuple[list[str], tuple[Array, ...]]:
    """Names, and means over every piece, the one behind and the one before ``# (S·pieces, features)`` each."""
    tables = [signed_features(trajectory) for trajectory in problem.data]
    names = list(tables[0])
    columns = [np.stack([table[name] for name in names], axis=1) for table in tables]
    return names, tuple(means(problem, columns, move) for move in MOVES)


def means(problem: Problem, columns: Sequence[Array], move: int) -> Array:
    """Of every log's columns ``# (rows, F)`` over every piece, or the one before or behind ``# (S·pieces, F)``."""
    segments, edges = problem.segments, [*pairwise(problem.segments.edges(PIECES))]
    starts = zip(segments.log, segments.row, strict=True)
    return np.stack([_mean(columns[log], row + a, row + b, move) for log, row in starts for a, b in edges])


def _mean(column: Array, first: int, last: int, move: int) -> Array:
    """Over rows from first to before last, moved by so many times their number as far as there are rows ``# (F,)``."""
    away = np.clip(move * (last - first), -first, len(column) - last)
    return np.asarray(column[first + away : last + away].mean(axis=0))


def within(columns: Array, log: NDArray[np.int64]) -> Array:
    """Columns ``# (pieces, columns)`` less their mean over every log."""
    _, place = np.unique(log, return_inverse=True)
    means = np.stack([columns[place == index].mean(axis=0) for index in range(place.max() + 1)])
    return np.asarray(columns - means[place])


def ahead_of(problem: Problem) -> Tensor | None:
    """Where the robot points in every piece, level, of length one ``# (S, pieces, 2)``; None where nobody knows."""
    layout = problem.segments.layout
    if not layout.has_field(ATTITUDE.name):
        return None
    first = np.array([[1.0, 0.0, 0.0]])
    ahead = [derive.to_world(attitudes(layout, log.state), first)[:, :2] for log in problem.data]
    return torch.nn.functional.normalize(torch.as_tensor(means(problem, ahead, 0)).unflatten(0, (-1, PIECES)), dim=-1)


def part_of_changes(segments: Segments, changes: Tensor) -> float:
    """Largest part of any field's motion that changes in segments make ``# (S, N·C)``."""
    paths, middle = changes.unflatten(1, (segments.length, -1)), (segments.length - 1) // 2
    moved = paths[:, -1] - 2 * paths[:, middle] + paths[:, 0]
    first, centre, last = (segments.measured[:, row] for row in (0, middle, -1))
    measured = segments.layout.difference(last, centre) - segments.layout.difference(centre, first)
    motion, fields = measured[:, list(segments.compared)], torch.tensor(segments.channel)
    return max(_size(moved[:, fields == field]) / _size(motion[:, fields == field]) for field in fields.unique())


def _size(moved: Tensor) -> float:
    """Root mean square of norms ``# (S, ·)``."""
    return max(float(moved.square().sum(1).mean().sqrt()), 1e-12)
