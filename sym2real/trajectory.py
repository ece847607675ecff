"""Trajectories as they were measured or simulated, and the transitions that models are fitted to.

Row k: state k was measured, then action k was sent (as sent, not as wished); state k+1 is the answer.
Arrays are float64 NumPy; torch enters where models do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.past import past_of_rows
from sym2real.upward import upward

if TYPE_CHECKING:
    import pandas

Array = NDArray[np.float64]


def _checked(name: str, values: Array, rows: int, layout: Layout) -> None:
    if values.shape != (rows, layout.size):
        raise ShapeError(
            f"{name} must have shape ({rows}, {layout.size}) for columns {layout.columns}, found {values.shape}"
        )


@dataclass(frozen=True, eq=False, repr=False)
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

    Examples:
        >>> layouts = Layouts.of(["x", "y", "vx", "vy", "steer", "speed"])
        >>> log = Trajectory.from_arrays(np.zeros((5, 4)), np.zeros((5, 2)), layouts, dt=0.05, name="parked")
        >>> log
        <Trajectory 'parked': 5 rows of x y vx vy, sent steer speed>
        >>> log.to_pandas().columns.tolist()
        ['time', 'x', 'y', 'vx', 'vy', 'steer', 'speed']
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

    @classmethod
    def from_arrays(
        cls,
        state: ArrayLike,
        action: ArrayLike,
        layouts: Layouts,
        *,
        time: ArrayLike | None = None,
        dt: float | None = None,
        inputs: ArrayLike | None = None,
        name: str = "",
    ) -> Trajectory:
        """A log from arrays whose columns are those of a model or a robot.

        Args:
            state: measured states; row k before action k ``# (rows, state)``.
            action: as sent ``# (rows, action)``.
            layouts: what the columns mean: ``model.layouts``, ``robot.layouts``, or ``Layouts.of(names)``.
            time: stamps in s ``# (rows,)``.
            dt: time step in s, where there are no stamps.
            inputs: known inputs; zero by default ``# (rows, inputs)``.
            name: what to call it.

        Raises:
            ShapeError: when shapes do not fit, or there is neither ``time`` nor ``dt``.
        """
        if time is not None and dt is None:
            stamps = np.asarray(time, dtype=np.float64)
        elif dt is not None and time is None:
            stamps = np.arange(len(np.asarray(state)), dtype=np.float64) * dt
        else:
            raise ShapeError(f"expected either time or dt, found {'neither' if dt is None else 'both'}")
        states, actions = (np.asarray(values, dtype=np.float64) for values in (state, action))
        given = np.zeros((len(states), layouts.inputs.size)) if inputs is None else np.asarray(inputs, dtype=np.float64)
        return cls(stamps, states, actions, given, layouts, name=name)

    @classmethod
    def from_pandas(
        cls,
        frame: pandas.DataFrame,
        spec: object = None,
        layouts: Layouts | None = None,
        dt: float | None = None,
    ) -> Trajectory:
        """A log from a data frame, as :func:`~sym2real.read_log` reads one from a file.

        Args:
            frame: a row per stamp, the time in s in the column ``time``; columns with standard names and units, or
                with those that ``spec`` maps.
            spec: a :class:`~sym2real.LogSpec`, the name of a shipped one, or a TOML file.
            layouts, dt: as of :func:`~sym2real.read_log`.

        Raises:
            DataError: naming row and column, what was expected and what was found.
        """
        log: Trajectory = upward("log_of_frame")(frame, spec, layouts, dt)
        return log

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with ``time``, state, action, inputs and extra; :meth:`from_pandas` reads it back.

        Raises:
            MissingDependencyError: without pandas, an extra.
        """
        frame: pandas.DataFrame = upward("frame_of_log")(self)
        return frame

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        columns = " ".join(self.layouts.state), " ".join(self.layouts.action)
        return f"<Trajectory {self.name!r}: {len(self)} rows of {columns[0]}, sent {columns[1]}>"

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


@dataclass(frozen=True, eq=False, repr=False)
class Dataset:
    """Trajectories with the same columns.

    Raises:
        ShapeError: when the trajectories' layouts differ.

    Examples:
        >>> log = Trajectory.from_arrays(np.zeros((5, 7)), np.zeros((5, 2)), car(wheelbase=0.3).layouts, dt=0.05)
        >>> Dataset([log, log]).rows, len(Dataset([log, log]).transitions())
        (10, 8)
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

    def __repr__(self) -> str:
        names = ", ".join(repr(one.name) for one in self)
        return f"<Dataset of {len(self)}: {names}>"

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
