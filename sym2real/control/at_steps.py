"""What a reference says at a controller's steps, many steps at once: torch's calls would take most of a step's time."""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import torch
from torch import Tensor

from sym2real.tasks import Task

AHEAD = 100  # steps that are computed at once
ROWS_AHEAD = 1000  # and of a table, whose rows are cheap: torch's calls take most of a block's time
Wanted = TypeVar("Wanted")


class AtSteps(Generic[Wanted]):
    """Of every step what is wanted there, whatever the state.

    Args:
        wanted: at times in s ``# (n,)``, one by one.
        dt: control period in s.
    """

    def __init__(self, wanted: Callable[[Tensor], Sequence[Wanted]], dt: float) -> None:
        self._wanted, self._dt = wanted, dt
        self._first = 0
        self._known: Sequence[Wanted] = ()

    def __getitem__(self, step: int) -> Wanted:
        if not 0 <= step - self._first < len(self._known):
            steps = torch.arange(step, step + AHEAD, dtype=torch.float64)
            self._first, self._known = step, self._wanted(steps * self._dt)
        return self._known[step - self._first]


class ReferenceTable:
    """Rows of a task's reference, as many at once as a plan's horizon has.

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
            steps = torch.arange(step + 1, step + self.horizon + ROWS_AHEAD, dtype=torch.float64)
            self._rows = self.task.reference(steps * self.dt).to(self.kind).contiguous()
        return self._rows[place : place + self.horizon]
