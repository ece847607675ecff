"""References of a task ahead of time, a block of steps at once: looking one up costs nothing."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from sym2real.tasks import Task

AHEAD = 64  # steps computed at once beyond the horizon


class ReferenceTable:
    """Rows of a task's reference.

    Args:
        task: its reference depends on time alone.
        dt: control period in s.
        horizon: rows that are asked for at once.
    """

    def __init__(self, task: Task, dt: float, horizon: int) -> None:
        self.task, self.dt, self.horizon = task, dt, horizon
        self._first = self._address = 0
        self._rows: NDArray[np.float32] = np.empty((0, 0), dtype=np.float32)

    def address(self, step: int) -> int:
        """Where the references ``# (H, state)`` at the steps ``step + 1 … step + H`` lie, as float32, row after row."""
        start = step + 1 - self._first
        if start < 0 or start + self.horizon > len(self._rows):
            self._first, start = step + 1, 0
            steps = torch.arange(step + 1, step + 1 + self.horizon + AHEAD, dtype=torch.float64)
            self._rows = np.ascontiguousarray(self.task.reference(steps * self.dt).numpy(), dtype=np.float32)
            self._address = self._rows.ctypes.data
        return self._address + start * self._rows.strides[0]
