"""What a reference says at a controller's steps, many steps at once: torch's calls would take most of a step's time."""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import torch
from torch import Tensor

AHEAD = 100  # steps that are computed at once
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
