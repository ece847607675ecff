"""Short pieces of logs that a model is fitted to: where they start, what was measured in them, how they are parted.

A segment compares positions, attitude and body rates with the prediction from a start that is free. Velocities are
compared where they are measurements of their own; most logs have them by differencing what is compared already.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from itertools import chain
from math import ceil
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import rows_of, without_stops
from sym2real.diagnosis.data.start import ROWS, start_states
from sym2real.diagnosis.settings import SETTINGS
from sym2real.errors import ShapeError
from sym2real.layout import Layout
from sym2real.logs.measured_rates import measured_rates
from sym2real.logs.noise import component_noise
from sym2real.trajectory import Array
from sym2real.vocabulary import JOINT_ANGLE, JOINT_DISPLACEMENT

# Fewest rows of a segment, and how long it is at least (s): in a tenth of a second noise hides what moves a robot by
# metres in a second, and in half a second what slows a car.
LENGTH, OF_A_CAR = (25, 0.5), (20, 1.0)
# Rows of a log before the first segment: filters and smoothers settle in them.
SETTLING = 12
# Fewest rows before a segment, through which hidden states are brought to its start, and of longer logs for how long.
WARM_UP, WARM_UP_SECONDS = 8, 0.5
# Folds of the cross-validation where there are fewer logs.
FEWEST_FOLDS = 4
# Of a block of the cluster-robust tests, or a little longer: it holds whole segments.
BLOCK_SECONDS = 1.5
COMPARED = ("position", "attitude", "heading", "rate", JOINT_DISPLACEMENT.name, JOINT_ANGLE.name)


@dataclass(frozen=True, eq=False)
class Segments:
    """Pieces of a data set.

    Args:
        log: which log each is from ``# (S,)``.
        row: its first row there ``# (S,)``.
        start: estimated state at the first row ``# (S, state)``.
        warm_up: rows before it through which hidden states go ``# (S,)``.
        before: estimated state so many rows earlier ``# (S, state)``.
        measured: ``# (S, N, state)``.
        layout: state columns of the log.
        compared: positions in the tangent of what is compared ``# (C,)``.
        channel: number of the field of each compared component ``# (C,)``.
        noise: standard deviation of each compared component from third differences ``# (C,)``.
    """

    log: NDArray[np.int64]
    row: NDArray[np.int64]
    start: Tensor
    warm_up: NDArray[np.int64]
    before: Tensor
    measured: Tensor
    layout: Layout
    compared: tuple[int, ...]
    channel: tuple[int, ...]
    noise: Array

    def __len__(self) -> int:
        return len(self.log)

    @property
    def length(self) -> int:
        """Rows of a segment."""
        return self.measured.shape[1]

    def some(self, most: int) -> Segments:
        """About so many of them, evenly over every log, whatever the logs' order."""
        number = number_in_log(self.log)
        share = min(1.0, most / len(self))
        return self.of(torch.as_tensor(np.ceil(share * (number + 1)) > np.ceil(share * number)))

    def of(self, which: Tensor) -> Segments:
        """Those of an index or mask ``# (S,)``."""
        own = ("log", "row", "start", "warm_up", "before", "measured")
        return replace(self, **{name: getattr(self, name)[which.numpy()] for name in own})

    def edges(self, pieces: int) -> NDArray[np.int64]:
        """Steps at which equal pieces of a segment begin, and the last one ends ``# (pieces + 1,)``."""
        return np.linspace(0, self.length - 1, pieces + 1).round().astype(np.int64)

    def rows_before(self) -> NDArray[np.int64]:
        """Rows that lead to each segment, and beyond where its warm-up is shorter than others' ``# (S, longest)``."""
        return (self.row - self.warm_up)[:, None] + np.arange(self.warm_up.max())

    def ahead(self) -> NDArray[np.int64]:
        """Rows whose actions lead through each segment ``# (S, N - 1)``."""
        return self.row[:, None] + np.arange(self.length - 1)


def segment_length(layout: Layout, dt: float) -> int:
    """Rows of a segment for a robot with these state columns, a time step in s apart."""
    rows, seconds = OF_A_CAR if layout.has_field("heading") else LENGTH
    return max(rows, round(seconds / dt))


def cut(data: Dataset, fields: Collection[str] | None = None, length: int | None = None) -> Segments:
    """Segments of all logs, without overlap.

    Args:
        data: logs.
        fields: what is compared; by default what these logs measure.
        length: rows of each; by default :func:`segment_length`.

    Raises:
        ShapeError: when no log is long enough for one.
    """
    length = length or segment_length(data.layouts.state, data.dt)
    first = SETTLING + WARM_UP
    rows = (without_stops(own, np.arange(first, len(own) - length, length), length) for own in data)
    starts = [(log, row) for log, own in enumerate(rows) for row in own.tolist()]
    steps = (np.diff(data[log].state[row : row + length], axis=0) for log, row in starts)
    moving = [at for at, step in zip(starts, steps, strict=True) if (step == 0).all(axis=1).mean() <= SETTINGS.frozen]
    if not moving:
        raise _without_segments(data, first + length + 1)
    log, row = np.array(moving, dtype=np.int64).T
    return segments_at(data, log, row, length, fields or (*COMPARED, *measured_rates(data)))


def segments_at(
    data: Dataset, log: NDArray[np.int64], row: NDArray[np.int64], length: int, names: Collection[str]
) -> Segments:
    """So many rows of these logs from each of these rows on ``# (S,)``, fields of these names compared."""
    compared, channel = compared_components(data.layouts.state, names)
    warm_up = np.minimum(max(WARM_UP, round(WARM_UP_SECONDS / data.dt)), np.maximum(row - ROWS + 1, WARM_UP))
    return Segments(
        log=log,
        row=row,
        start=_states(data, log, row),
        warm_up=warm_up,
        before=_states(data, log, row - warm_up),
        measured=torch.as_tensor(np.stack([data[i].state[k : k + length] for i, k in zip(log, row, strict=True)])),
        layout=data.layouts.state,
        compared=compared,
        channel=channel,
        noise=component_noise(data)[list(compared)],
    )


def compared_components(layout: Layout, names: Collection[str]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Tangent positions of what is compared, fields of these names, and the number of the field of each.

    All fields where none has such a name.
    """
    shown = [number for number, field in enumerate(layout.fields) if not field.hidden]
    numbers = [number for number in shown if layout.fields[number].name in names] or shown
    places = [layout.tangent_places[number] for number in numbers]
    return tuple(chain(*places)), tuple(np.repeat(numbers, [len(own) for own in places]).tolist())


def compared_fields(segments: Segments) -> tuple[Layout, list[int]]:
    """The fields that are compared, and the places of their columns among all."""
    part = Layout(tuple(segments.layout.fields[number] for number in dict.fromkeys(segments.channel)))
    return part, segments.layout.indices(part)


def _without_segments(data: Dataset, needed: int) -> ShapeError:
    wanted, names = f"a log of at least {needed} moving rows", ", ".join(log.name for log in data)
    if any(len(log) >= needed for log in data):
        return ShapeError(
            f"expected {wanted}, found that the measured state does not change from row to row in {names}: "
            "a sensor or a link that stood still, or a robot that did"
        )
    return ShapeError(f"expected {wanted}, found {rows_of(list(data))}")


def _states(data: Dataset, log: NDArray[np.int64], row: NDArray[Any]) -> Tensor:
    states = np.empty((len(row), data.layouts.state.size))
    for index, trajectory in enumerate(data):
        mine = log == index
        states[mine] = start_states(trajectory, np.maximum(row[mine], ROWS - 1))
    return torch.as_tensor(states)


def padded(arrays: Iterable[Array]) -> Tensor:
    """Arrays of different lengths, the last row repeated, as one tensor ``# (logs, rows, columns)``."""
    arrays = list(arrays)
    longest = max(len(array) for array in arrays)
    return torch.as_tensor(np.stack([np.pad(own, ((0, longest - len(own)), (0, 0)), mode="edge") for own in arrays]))


def folds_of(segments: Segments) -> NDArray[np.int64]:
    """Fold of every segment ``# (S,)``: leave one log out; few logs are parted further in time."""
    log = segments.log
    parts = max(1, ceil(FEWEST_FOLDS / len(np.unique(log))))
    folds = log * parts + number_in_log(log) * parts // np.bincount(log)[log]
    return np.unique(folds, return_inverse=True)[1].astype(np.int64)


def number_in_log(log: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many stand before each in its log; logs in their order ``# (S,)``."""
    return np.arange(len(log)) - np.searchsorted(log, log)


def summed(values: Tensor, parts: NDArray[np.int64]) -> Tensor:
    """Sums over parts, by the part of every segment ``# (S,)``, of what all have ``# (S, ...) -> (parts, ...)``."""
    return values.new_zeros(int(parts.max()) + 1, *values.shape[1:]).index_add(0, torch.as_tensor(parts), values)


def blocks_of(segments: Segments, dt: float) -> NDArray[np.int64]:
    """Block of every segment ``# (S,)``; a log's last block may be shorter.

    Args:
        segments: in the order of their logs.
        dt: time step in s.
    """
    inside = ceil(BLOCK_SECONDS / (segments.length * dt) - 1e-9)
    numbers: NDArray[np.int64] = segments.log * len(segments) + number_in_log(segments.log) // inside
    return np.unique(numbers, return_inverse=True)[1].astype(np.int64)
