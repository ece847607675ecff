"""What every variant of a model predicts from starts along logs, in one rollout a variant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS
from sym2real.diagnosis.data.start import Start, start_states
from sym2real.diagnosis.data.windows import JUDGED_AT, stride_of
from sym2real.effects.along_logs import predicted_from
from sym2real.protocols import DynamicsModel
from sym2real.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Starts:
    """Windows of logs, every 0.1 s; those near a log's end are as long as it lasts.

    Args:
        data: the logs.
        log, row: where each window starts ``# (W,)``.
        state: its start state ``# (W, state)``.
        steps: length of a window.
    """

    data: Dataset
    log: NDArray[np.int64]
    row: NDArray[np.int64]
    state: NDArray[np.float64]
    steps: int

    @classmethod
    def of(cls, data: Dataset, steps: int, method: Start = "smoothed") -> Starts:
        """Every window that is at least one step long.

        Args:
            data: logs, one of them at least longer than the rows that a start is estimated from.
            steps: length of a window.
            method: how start states are estimated.
        """
        stride, parts = stride_of(data.dt), []
        for index, trajectory in enumerate(data):
            rows = np.arange(ROWS - 1, len(trajectory) - 1, stride)
            if len(rows):
                parts.append((np.full(len(rows), index), rows, start_states(trajectory, rows, method)))
        log, row, state = (np.concatenate(part) for part in zip(*parts, strict=True))
        return cls(data, log, row, state, steps)

    @property
    def by_log(self) -> list[tuple[Trajectory, NDArray[np.bool_]]]:
        """Every log, and which windows lie in it ``# (W,)``."""
        return [(log, self.log == index) for index, log in enumerate(self.data)]

    @property
    def left(self) -> NDArray[np.int64]:
        """Rows that each window's log has behind its start ``# (W,)``."""
        return np.array([len(log) for log in self.data])[self.log] - 1 - self.row

    @property
    def measured(self) -> Tensor:
        """``# (W, steps, state)``; behind a log's end its last row."""
        ahead = self.row[:, None] + np.minimum(np.arange(1, self.steps + 1), self.left[:, None])
        return torch.as_tensor(np.concatenate([log.state[ahead[mine]] for log, mine in self.by_log]))

    def predicted(self, model: DynamicsModel, logs: Dataset) -> Tensor:
        """What a model predicts ``# (W, steps, state)``; behind a log's end not a number.

        Args:
            model: of any precision.
            logs: the data as the model takes them: with its inputs, and the commands that reach the robot.
        """
        parts = [(log, self.log == index) for index, log in enumerate(logs)]
        states = torch.cat(
            [predicted_from(model, log, self.row[mine], self.steps, start=self.state[mine]) for log, mine in parts]
        )
        states[torch.as_tensor(np.arange(self.steps) >= self.left[:, None])] = torch.nan
        return states

    def along(self, predicted: Tensor) -> list[NDArray[np.float64]]:
        """By log, states predicted in pieces of ``JUDGED_AT`` s ``# (rows, state)``; two rows between are NaN.

        Args:
            predicted: of every window ``# (W, steps, state)``.
        """
        by_log = []
        for log, mine in self.by_log:
            rows, pieces = self.row[mine], predicted[torch.as_tensor(mine)].numpy()
            stride = int(rows[1] - rows[0]) if len(rows) > 1 else 1
            every = max(1, min(round(JUDGED_AT / log.dt), self.steps) // stride)
            states = np.full((len(log), self.data.layouts.state.size), np.nan)
            for row, piece in zip(rows[::every], pieces[::every], strict=True):
                last = min(row + every * stride - 1, len(log), row + 1 + self.steps)
                states[row + 1 : last] = piece[: last - row - 1]
            by_log.append(states)
        return by_log
