"""What a disturbance may depend on (time, place, motion, commands), and how much of a robot's motion it makes.

By how far it moves the robot, that is, beside how far the robot moves. Both are second differences over a segment, its
end and its start less twice its middle: going on as before is no motion. Logs with little noise show disturbances that
no prediction needs: the integration error of the simulator that wrote them, for one.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import Segments
from sym2real.diagnosis.estimate.whitening import PIECES, Spread
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.logs import derive
from sym2real.logs.conditions import signed_features
from sym2real.logs.pose import attitudes
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, FORCE, HEADING

TURNED = " in the robot's axes"  # behind the name of a level force


def features_of(problem: Problem) -> tuple[list[str], tuple[Array, ...]]:
    """Names, and means over the piece before every piece, itself, and the one behind ``# (S·pieces, features)``."""
    tables = [signed_features(trajectory) for trajectory in problem.data]
    names = list(tables[0])
    columns = [np.stack([table[name] for name in names], axis=1) for table in tables]
    return names, tuple(_means(problem, columns, move) for move in (-1, 0, 1))


def _means(problem: Problem, columns: Sequence[Array], move: int = 0) -> Array:
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


def axes_of(problem: Problem, names: tuple[str, ...]) -> tuple[tuple[str, ...], Array]:
    """Names of disturbances, and what each is made of ``# (names, S·pieces, D)``: themselves, and level forces turned.

    The robot's axes are level, and forward where it points.
    """
    count, level = len(problem.segments) * PIECES, list(FORCE.columns[:2])
    own = np.repeat(np.eye(len(names))[:, None], count, axis=1)
    layout = problem.segments.layout
    if not (set(level) <= set(names) and (layout.has_field(ATTITUDE.name) or layout.has_field(HEADING.name))):
        return names, own
    ahead = [derive.to_world(attitudes(layout, log.state), np.array([[1.0, 0.0, 0.0]])) for log in problem.data]
    x, y = _unit(_means(problem, [forward[:, :2] for forward in ahead])).T
    turned = np.zeros((2, count, len(names)))
    turned[:, :, [names.index(name) for name in level]] = np.stack([np.stack([x, y], 1), np.stack([-y, x], 1)])
    return (*names, *(name + TURNED for name in level)), np.concatenate([own, turned])


def part_of_disturbance(segments: Segments, spread: Spread, name: str, disturbance: Array | float) -> float:
    """Largest part of any field's motion that a disturbance makes.

    Args:
        segments: of the logs.
        spread: shapes of the disturbances.
        name: of this one.
        disturbance: over every piece ``# (S·pieces,)``, or the same everywhere, in its unit.
    """
    disturbances = np.zeros((len(segments) * PIECES, len(spread.names)))
    disturbances[:, spread.names.index(name)] = disturbance
    return part_of_disturbances(segments, spread, disturbances)


def part_of_disturbances(segments: Segments, spread: Spread, disturbances: Array) -> float:
    """The same of all of them at once ``# (S·pieces, D)``."""
    pieces = (torch.as_tensor(disturbances) / spread.sizes).unflatten(0, (-1, PIECES))
    return part_of_changes(segments, torch.einsum("srdp,spd->sr", spread.disturbances, pieces))


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


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True).clip(1e-12))


def _size(moved: Tensor) -> float:
    """Root mean square of norms ``# (S, ·)``."""
    return max(float(moved.square().sum(1).mean().sqrt()), 1e-12)
