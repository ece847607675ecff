"""Trajectories as they were measured or simulated.

Row k: state k was measured, then action k was sent (as sent, not as wished); state k+1 is the answer.
Arrays are float64 NumPy; torch enters where models do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.past import past_of_rows
from sym2real.upward import upward

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
UNUSUAL = 0.5  # × the median interval, that another one may differ by: beyond, a row is missing or out of place


def check_shape(name: str, values: Array, rows: int, layout: Layout) -> None:
    """Refuse columns ``# (rows, columns)`` of another shape.

    Raises:
        ShapeError: naming the shape that the layout asks for.
    """
    if values.shape != (rows, layout.size):
        raise ShapeError(
            f"{name} must have shape ({rows}, {layout.size}) for columns {layout.columns}, found {values.shape}"
        )


def check_columns(name: str, shape: Sequence[int], layout: Layout) -> None:
    """Refuse values of another number of columns ``# (..., columns)``, by a ShapeError that names them."""
    if not shape or shape[-1] != layout.size:
        columns, actual = " ".join(layout) or "none", tuple(shape)
        raise ShapeError(f"{name}: expected (..., {layout.size}), columns {columns}, found shape {actual}")


def numbers_of(name: str, values: ArrayLike) -> Array:
    """Float64 of what a user gives, tensors with a gradient included.

    Raises:
        ShapeError: for what holds no rows of numbers, or rows of several lengths.
    """
    try:
        numbers = np.asarray(_detached(values), dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(())
    if not numbers.ndim:
        raise ShapeError(f"{name}: expected an array of numbers, found {values!r:.80}")
    return numbers


def seconds_of(time: ArrayLike) -> Array:
    """Stamps in s ``# (rows,)``; of dates, from the first one on.

    Raises:
        ShapeError: for what are no stamps, or more than one to a row.
    """
    stamps: Any = np.zeros(())
    try:
        stamps = np.asarray(_detached(time))
        stamps = stamps.astype("M8[ns]") if stamps.dtype.kind in "MO" else stamps
    except (TypeError, ValueError):
        pass
    if stamps.ndim != 1:
        raise ShapeError(f"time: expected a stamp for every row, found {time!r:.80}")
    return numbers_of("time", (stamps - stamps[:1]) / np.timedelta64(1, "s") if stamps.dtype.kind in "mM" else stamps)


def _detached(values: Any) -> Any:
    return values.detach() if hasattr(values, "detach") else values


def _even(dt: Any, rows: int) -> Array:
    try:
        step = nan if isinstance(dt, (bool, str)) else float(dt)
    except (TypeError, ValueError):
        step = nan
    if not 0.0 < step < inf:
        raise ShapeError(f"dt: expected a time step of more than 0 s, found {dt!r:.80}")
    return np.arange(rows, dtype=np.float64) * step


def require_finite(log: Trajectory) -> None:
    """Refuse states and commands that are no finite number, by a ShapeError that names log, row and column."""
    for group in ("state", "action"):
        values, columns = getattr(log, group), getattr(log.layouts, group).columns
        for row, column in np.argwhere(~np.isfinite(values))[:1]:
            place = f"column {columns[column]}, row {row + 1} of {log.name or 'a log'}"
            raise ShapeError(f"expected finite numbers, found {values[row, column]} in {place}")


def usual_interval(intervals: Array) -> float:
    """Mean of the usual ones of intervals between rows ``# (rows,)``: rounding of their stamps averages out."""
    if not len(intervals):
        return float("nan")
    median = np.median(intervals)
    return float(intervals[np.abs(intervals - median) <= UNUSUAL * median].mean())


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
        sources: standard column → the file's column that it was read from, with a minus where axes turned its sign;
            roll, pitch and yaw of an attitude that was logged so stand there too.
        along_body: velocities that the file has along the body's axes; its attitude or heading turned them.
        between: what was sent in equal parts of every row, where commands were not held ``# (rows, parts, action)``.

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
    sources: Mapping[str, str] = field(default_factory=dict)
    along_body: tuple[str, ...] = ()
    between: Array | None = None

    def __post_init__(self) -> None:
        rows = len(self.time)
        for name, layout in self.layouts.groups.items():
            check_shape(name, getattr(self, name), rows, layout)
        if self.between is not None and self.between.shape[::2] != self.action.shape:
            raise ShapeError(f"between must have shape (rows, parts, action), found {self.between.shape}")
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
            time: stamps in s, or dates ``# (rows,)``.
            dt: time step in s, where there are no stamps.
            inputs: known inputs; zero by default ``# (rows, inputs)``.
            name: what to call it.

        Raises:
            ShapeError: when shapes do not fit, for what are no numbers, or with neither or both of ``time`` and ``dt``.
        """
        if not isinstance(layouts, Layouts):
            raise ShapeError(f"layouts: expected Layouts, as of a model or Layouts.of(names), found {layouts!r:.80}")
        if (time is None) == (dt is None):
            raise ShapeError(f"expected either time or dt, found {'neither' if dt is None else 'both'}")
        states, actions = numbers_of("state", state), numbers_of("action", action)
        stamps = seconds_of(time) if time is not None else _even(dt, len(states))
        given = np.zeros((len(states), layouts.inputs.size)) if inputs is None else numbers_of("inputs", inputs)
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
        return upward("log_of_frame")(frame, spec, layouts, dt)

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with ``time``, state, action, inputs and extra; :meth:`from_pandas` reads it back.

        Raises:
            MissingDependencyError: without pandas, an extra.
        """
        return upward("frame_of_log")(self)

    def plot(self, **models: object) -> Figure:
        """The path and every position over time; with models, every column measured and predicted 0.8 s ahead.

        Args:
            models: at most two, by what the legend calls them: ``log.plot(before=model, after=informed)``.

        Raises:
            ShapeError: with models, when the log is too short to predict.
        """
        return upward("log_plot")(self, models)

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        columns = " ".join(self.layouts.state), " ".join(self.layouts.action)
        return f"<Trajectory {self.name!r}: {len(self)} rows of {columns[0]}, sent {columns[1]}>"

    @cached_property
    def dt(self) -> float:
        """Usual time step in s, see :func:`usual_interval`."""
        return usual_interval(np.diff(self.time))

    def column(self, name: str) -> Array:
        """One column of state, action, inputs or extra by name ``# (rows,)``.

        Raises:
            UnknownNameError: when there is no such column.
        """
        for group, layout in self.layouts.groups.items():
            if name in layout:
                column: Array = getattr(self, group)[:, layout.index(name)]
                return column
        if name in self.extra:
            return self.extra[name]
        return self.state[:, self.layouts.state.index(name)]

    def sent_in_parts(self, parts: int) -> Array:
        """What was sent in each of so many equal parts of every row ``# (rows, parts, action)``.

        Raises:
            ShapeError: where it is known for parts that do not make these up.
        """
        if self.between is None:
            return np.repeat(self.action[:, None], parts, axis=1)
        rows, known, columns = self.between.shape
        if known % parts:
            raise ShapeError(f"expected what was sent in {parts} parts of every row, found {known}")
        return np.asarray(self.between.reshape(rows, parts, known // parts, columns).mean(2))

    def changed(self, change: Callable[[Trajectory], Trajectory]) -> Trajectory:
        """The log after a change of columns, of what was sent in the parts of a row as of the rows."""
        after = change(self)
        if self.between is None:
            return after
        parts = [change(replace(self, action=part)).action for part in self.between.swapaxes(0, 1)]
        return replace(after, between=np.stack(parts, axis=1))

    def with_columns(self, columns: Mapping[str, Array]) -> Trajectory:
        """The log with other values ``# (rows,)`` in columns of its three groups; others are left out."""
        changed = {}
        for group, layout in self.layouts.groups.items():
            values = getattr(self, group).copy()
            for name in (name for name in columns if name in layout):
                values[:, layout.index(name)] = columns[name]
            changed[group] = values
        return replace(self, **changed)

    @cached_property
    def step_inputs(self) -> Array:
        """Inputs from each row to the next ``# (rows, inputs)``, see :meth:`~sym2real.layout.Layout.over_steps`."""
        return self.layouts.inputs.over_steps(self.inputs)

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
            between=None if self.between is None else self.between[start:stop],
            extra={name: values[start:stop] for name, values in self.extra.items()},
        )
