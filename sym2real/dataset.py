"""Trajectories with the same columns, and the transitions that models are fitted to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.past import past_of_rows
from sym2real.trajectory import Array, Trajectory, check_shape

SAME_STEP = 0.02  # part of the time step by which those of logs in one set may differ
FEW = 10  # rows; fewer, between two gaps, tell no step


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
        for name, layout in self.layouts.groups.items():
            check_shape(name, getattr(self, name), rows, layout)
        check_shape("next_state", self.next_state, rows, self.layouts.state)

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
        rows = ("state", "action", "inputs", "next_state", "trajectory", "step")
        return replace(self, **{name: getattr(self, name)[mask] for name in rows})


@dataclass(frozen=True, eq=False, repr=False)
class Dataset:
    """Trajectories with the same columns.

    Raises:
        ShapeError: for what is no trajectory; when their layouts differ, or their steps by more than :data:`SAME_STEP`.

    Examples:
        >>> log = Trajectory.from_arrays(np.zeros((5, 7)), np.zeros((5, 2)), car(wheelbase=0.3).layouts, dt=0.05)
        >>> Dataset([log, log]).rows, len(Dataset([log, log]).transitions())
        (10, 8)
    """

    trajectories: tuple[Trajectory, ...]

    def __init__(self, trajectories: Iterable[Trajectory]) -> None:
        object.__setattr__(self, "trajectories", logs_in(trajectories))
        for other in self.trajectories[1:]:
            if other.layouts != self.layouts:
                raise ShapeError(
                    f"trajectories {self.trajectories[0].name!r} and {other.name!r} have different columns"
                )
        self._check_steps()

    def _check_steps(self) -> None:
        steps = [(_called(log, number), log.dt) for number, log in enumerate(self.trajectories, 1) if len(log) >= FEW]
        for other in steps[1:]:
            (first, usual), (name, dt) = steps[0], other
            if abs(dt - usual) > SAME_STEP * min(dt, usual):
                raise ShapeError(
                    f"{first} has a time step of {usual:.4g} s, {name} one of {dt:.4g} s: expected one step of all "
                    "logs in a set (read_logs with dt brings files to one)"
                )

    def __len__(self) -> int:
        return len(self.trajectories)

    def __repr__(self) -> str:
        names = ", ".join(repr(log.name) for log in self)
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
        """Median time step in s over the trajectories; NaN where none has two rows."""
        steps = [trajectory.dt for trajectory in self.trajectories if len(trajectory) > 1]
        return float(np.median(steps)) if steps else nan

    @property
    def rows(self) -> int:
        """Number of rows of all trajectories."""
        return sum(len(trajectory) for trajectory in self.trajectories)

    def told_apart(self) -> Dataset:
        """The logs with a name each, by which others are found for them; as they are where they have that.

        Logs without a name are named by their number; of logs with one name the later ones have theirs behind it.
        """
        names = list[str]()
        for number, log in enumerate(self, 1):
            name = log.name or f"log {number}"
            names.append(name if name not in names else f"{name} ({number})")
        if names == [log.name for log in self]:
            return self
        return Dataset(replace(log, name=name) for log, name in zip(self, names, strict=True))

    def transitions(self) -> Transitions:
        """Every consecutive pair of rows, never across two trajectories."""
        parts: Sequence[Trajectory] = self.trajectories
        return Transitions(
            state=np.concatenate([part.state[:-1] for part in parts]),
            action=np.concatenate([part.action[:-1] for part in parts]),
            inputs=np.concatenate([part.step_inputs[:-1] for part in parts]),
            next_state=np.concatenate([part.state[1:] for part in parts]),
            layouts=self.layouts,
            dt=self.dt,
            trajectory=np.concatenate([np.full(len(part) - 1, i) for i, part in enumerate(parts)]),
            step=np.concatenate([np.arange(len(part) - 1) for part in parts]),
        )


def _called(log: Trajectory, number: int) -> str:
    return f"trajectory {log.name!r}" if log.name else f"trajectory number {number}"


# What is judged: logs in a data set or a list, or one.
Logs: TypeAlias = "Dataset | Sequence[Trajectory] | Trajectory"


def logs_in(data: Iterable[Trajectory] | Trajectory) -> tuple[Trajectory, ...]:
    """Each of the logs.

    Raises:
        ShapeError: for anything else, such as a path, an array or a data frame, with what makes a log of it.
    """
    given = (data,) if isinstance(data, Trajectory) or not isinstance(data, Iterable) else tuple(data)
    wrong = [type(log).__name__ for log in given if not isinstance(log, Trajectory)]
    if not wrong:
        return given
    inside = f" of {wrong[0]}" if isinstance(data, list | tuple) else ""
    actual = repr(data) if isinstance(data, str | Path) else f"{type(data).__name__}{inside}"
    raise ShapeError(
        f"expected logs (a Trajectory, a list of them or a Dataset), found {actual:.80}; read_log(path, spec, "
        "model.layouts, model.dt) makes one of a file, Trajectory.from_pandas of a data frame, "
        "Trajectory.from_arrays(state, action, model.layouts, dt=…) of arrays"
    )
