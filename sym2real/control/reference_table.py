"""References of a task ahead of time, a block of steps at once: looking one up costs nothing."""

import torch
from torch import Tensor

from sym2real.tasks import Task

AHEAD = 1000  # steps computed at once beyond the horizon: rows are cheap, torch's calls take most of a block's time


class ReferenceTable:
    """Rows of a task's reference.

    Args:
        task: its reference depends on time alone.
        dt: control period in s.
        horizon: rows that are asked for at once.
        kind: a tensor on the device and in the precision in which they are wanted.
    """

    def __init__(self, task: Task, dt: float, horizon: int, kind: Tensor) -> None:
        self.task, self.dt, self.horizon, self.kind = task, dt, horizon, kind
        self._first, self._rows = 0, torch.empty(0)

    def after(self, step: int) -> Tensor:
        """References ``# (H, state)`` at the steps ``step + 1 … step + H``, row after row."""
        place = step + 1 - self._first
        if not 0 <= place <= len(self._rows) - self.horizon:
            self._first, place = step + 1, 0
            steps = torch.arange(step + 1, step + self.horizon + AHEAD, dtype=torch.float64)
            self._rows = self.task.reference(steps * self.dt).to(self.kind).contiguous()
        return self._rows[place : place + self.horizon]
