"""Trajectories as they were measured or simulated, and the transitions that models are fitted to.

Row k: state k was measured, then action k was sent (as sent, not as wished); state k+1 is the answer.
Arrays are float64 NumPy; torch enters where models do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.past import past_of_rows

Array = NDArray[np.float64]


def _checked(name: str, values: Array, rows: int, layout: Layout) -> None:
    if values.shape != (rows, layout.size):
        raise ShapeError(
            f"{name} must have shape ({rows}, {layout.size}) for columns {layout.columns}, found {values.shape}"
        )


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One flight or drive.

    Args:
        time: stamps in s, strictly increasing ``# (rows,)``.
        state: measured states ``# (rows, state)``.
        action: actions sent ``# (rows, action)``.
        inputs: known inputs ``# (rows, inputs)``.
        layouts: what the columns mean.
        extra: further columns by name, each ``# (rows,)`` (references as ``ref_x``, raw sensors).
        name: what to call it, usually the file's stem.
        notes: what was done to it on the way in (rows dropped, resampled, …), one sentence each.
        raw: every column of the file as it stood there, before anything was done, by its own name.

    Raises:
        ShapeError: when shapes do not fit the layouts or stamps do not increase.
    """

    time: Array
    state: Array
    action: Array
    inputs: Array
    layouts: Layouts
    extra: Mapping[str, Array] = field(default_factory=dict)
    name: str = ""
    notes: tuple[str, ...] = ()
    raw: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows = len(self.time)
        _checked("state", self.state, rows, self.layouts.state)
        _checked("action", self.action, rows, self.layouts.action)
        _checked("inputs", self.inputs, rows, self.layouts.inputs)
        for column, values in self.extra.items():
            if values.shape != (rows,):
                raise ShapeError(f"extra column {column!r} must have shape ({rows},), found {values.shape}")
        if rows > 1 and not (np.diff(self.time) > 0).all():
            raise ShapeError(f"time of trajectory {self.name!r} must increase strictly")

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def dt(self) -> float:
        """Median time step in s."""
        return float(np.median(np.diff(self.time)))

    def column(self, name: str) -> Array:
        """One column of state, action, inputs or extra by name ``# (rows,)``.

        Raises:
            UnknownNameError: when there is no such column.
        """
        for layout, values in (
            (self.layouts.state, self.state),
            (self.layouts.action, self.action),
            (self.layouts.inputs, self.inputs),
        ):
            if name in layout:
                column: Array = values[:, layout.index(name)]
                return column
        if name in self.extra:
            return self.extra[name]
        return self.state[:, self.layouts.state.index(name)]

    def past(self, commands: int, states: int) -> Array:
        """Commands sent before each row, newest first, then states ``# (rows, commands·action + states·state)``.

        The first row is repeated before the start.
        """
        return past_of_rows(self.action, self.state, np.zeros(len(self), dtype=np.int64), commands, states)

    def rows(self, start: int, stop: int) -> Trajectory:
        """The rows ``start … stop-1`` as a trajectory of its own."""
        return replace(
            self,
            time=self.time[start:stop],
            state=self.state[start:stop],
            action=self.action[start:stop],
            inputs=self.inputs[start:stop],
            extra={name: values[start:stop] for name, values in self.extra.items()},
        )


@dataclass(frozen=True, eq=False)
class Transitions:
    """State, action and inputs of a step and the state that followed.

    Args:
        state: ``# (rows, state)``.
        action: ``# (rows, action)``.
        inputs: ``# (rows, inputs)``.
        next_state: ``# (rows, state)``.
        layouts: what the columns mean.
        dt: time step in s.
        trajectory: which trajectory a row belongs to, counted from 0 ``# (rows,)``.
        step: position of a row within its trajectory ``# (rows,)``.
    """

    state: Array
    action: Array
    inputs: Array
    next_state: Array
    layouts: Layouts
    dt: float
    trajectory: NDArray[np.int64]
    step: NDArray[np.int64]

    def __post_init__(self) -> None:
        rows = len(self.state)
        _checked("state", self.state, rows, self.layouts.state)
        _checked("action", self.action, rows, self.layouts.action)
        _checked("inputs", self.inputs, rows, self.layouts.inputs)
        _checked("next_state", self.next_state, rows, self.layouts.state)

    def __len__(self) -> int:
        return len(self.state)

    def past(self, commands: int, states: int) -> Array:
        """Commands sent before each row, newest first, then states ``# (rows, commands·action + states·state)``.

        The first row of a trajectory is repeated before its start, and so is the first one behind rows that
        :meth:`where` left out: take the past first, then choose rows.
        """
        begins = np.ones(len(self), dtype=bool)
        begins[1:] = (np.diff(self.trajectory) != 0) | (np.diff(self.step) != 1)
        first = np.maximum.accumulate(np.where(begins, np.arange(len(self)), 0))
        return past_of_rows(self.action, self.state, first, commands, states)

    def where(self, mask: NDArray[np.bool_]) -> Transitions:
        """The rows where ``mask`` holds."""
        return Transitions(
            self.state[mask],
            self.action[mask],
            self.inputs[mask],
            self.next_state[mask],
            self.layouts,
            self.dt,
            self.trajectory[mask],
            self.step[mask],
        )


@dataclass(frozen=True, eq=False)
class Dataset:
    """Trajectories with the same columns.

    Raises:
        ShapeError: when the trajectories' layouts differ.
    """

    trajectories: tuple[Trajectory, ...]

    def __init__(self, trajectories: Iterable[Trajectory]) -> None:
        object.__setattr__(self, "trajectories", tuple(trajectories))
        for other in self.trajectories[1:]:
            if other.layouts != self.layouts:
                raise ShapeError(
                    f"trajectories {self.trajectories[0].name!r} and {other.name!r} have different columns"
                )

    def __len__(self) -> int:
        return len(self.trajectories)

    def __iter__(self) -> Iterator[Trajectory]:
        return iter(self.trajectories)

    def __getitem__(self, position: int) -> Trajectory:
        return self.trajectories[position]

    def __add__(self, other: Dataset) -> Dataset:
        return Dataset(self.trajectories + other.trajectories)

    @property
    def layouts(self) -> Layouts:
        """Columns of all trajectories."""
        return self.trajectories[0].layouts

    @property
    def dt(self) -> float:
        """Median time step in s over the trajectories."""
        return float(np.median([trajectory.dt for trajectory in self.trajectories]))

    @property
    def rows(self) -> int:
        """Number of rows of all trajectories."""
        return sum(len(trajectory) for trajectory in self.trajectories)

    def transitions(self) -> Transitions:
        """Every consecutive pair of rows, never across two trajectories."""
        parts: Sequence[Trajectory] = self.trajectories
        return Transitions(
            state=np.concatenate([part.state[:-1] for part in parts]),
            action=np.concatenate([part.action[:-1] for part in parts]),
            inputs=np.concatenate([part.inputs[:-1] for part in parts]),
            next_state=np.concatenate([part.state[1:] for part in parts]),
            layouts=self.layouts,
            dt=self.dt,
            trajectory=np.concatenate([np.full(len(part) - 1, i) for i, part in enumerate(parts)]),
            step=np.concatenate([np.arange(len(part) - 1) for part in parts]),
        )
