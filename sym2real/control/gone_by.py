"""What MPPI keeps of the rows gone by: for the command filters, and for a model that sees the past."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control.fused_arguments import copy_of, single
from sym2real.control.fused_filters import memory_of
from sym2real.effects.filters import FilterState
from sym2real.past import Past, past_rows


class GoneBy:
    """Commands as sent and states as measured, in the forms in which a plan begins with them.

    Args:
        model: says by ``past_rows`` how much of the past it sees.
        filters: of the commands; None for none. The model's past is what comes out of them.
        device, dtype: of the rollouts.

    Attributes:
        measured: the state on which the next command is sent ``# (state,)``; None before there is any.
    """

    def __init__(self, model: object, filters: FilterState | None, device: torch.device, dtype: torch.dtype) -> None:
        self._filters, self._device, self._dtype = filters, device, dtype
        rows = past_rows(model)
        self._past = Past(*rows) if any(rows) else None
        self.reset()

    def reset(self) -> None:
        """Forget every row."""
        self.measured: ArrayLike | None = None
        if self._filters is not None:
            self._filters.reset()
        if self._past is not None:
            self._past.reset()

    def remember(self, sent: ArrayLike) -> None:
        """Add a row: the measured state, and a command ``# (action,)``."""
        if self._filters is not None:
            command = torch.from_numpy(copy_of(sent, np.float64)).to(self._device, self._dtype)
            sent = self._filters.remember(command).cpu().numpy()
        if self._past is not None:
            state = None if self.measured is None else copy_of(self.measured, np.float64)
            self._past.remember(copy_of(sent, np.float64), state)

    def memory(self) -> Tensor | None:
        """Of the filters as the kernel takes it; None before anything was sent."""
        if self._filters is None or not self._filters.memories:
            return None
        return single(memory_of(self._filters), self._device)

    def past(self, state: ArrayLike) -> Tensor | None:
        """Of a state ``# (columns,)``; None before anything was sent, or for a model that does not see it."""
        before = None if self._past is None else self._past.before(copy_of(state, np.float64))
        return None if before is None else torch.from_numpy(before).to(self._device, self._dtype)
