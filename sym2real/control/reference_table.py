"""References of a task ahead of time, a block of steps at once: looking one up costs nothing."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.tasks import Task

AHEAD = 64  # steps computed at once beyond the horizon


class ReferenceTable:
    """Rows of a task's reference.

    Args:
        task: its reference depends on time alone.
        dt: control period in s.
        horizon: rows that are asked for at once.
        device: where they are wanted, as float32.
    """

    def __init__(self, task: Task, dt: float, horizon: int, device: torch.device) -> None:
        self.task, self.dt, self.horizon, self.device = task, dt, horizon, device
        self._first, self._rows = 0, tuple[Tensor, ...]()

    def after(self, step: int) -> Tensor:
        """References ``# (H, state)`` at the steps ``step + 1 … step + H``, row after row."""
        place = step + 1 - self._first
        if not 0 <= place < len(self._rows):
            self._first, place = step + 1, 0
            steps = torch.arange(step + 1, step + self.horizon + AHEAD, dtype=torch.float64)
            rows = self.task.reference(steps * self.dt).to(self.device, torch.float32).contiguous()
            self._rows = rows.unfold(0, self.horizon, 1).transpose(1, 2).unbind(0)  # all views by one call
        return self._rows[place]
