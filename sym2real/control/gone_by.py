"""What MPPI keeps of the rows gone by: for command filters, hidden states, and a model that sees the past."""

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control.fused_arguments import copy_of, single
from sym2real.control.fused_filters import memory_of
from sym2real.control.hidden_states import HiddenStates
from sym2real.effects.filters import FilterState
from sym2real.past import Past, past_rows
from sym2real.symbolic import equations_of


class GoneBy:
    """Commands as sent and states as measured, in the forms in which a plan begins with them.

    Args:
        model: says by ``past_rows`` how much of the past it sees, and by ``equations`` which hidden states it has.
        filters: of the commands; None for none. The model's past, and its hidden states, see what comes out of them.
        device, dtype: of the rollouts.
    """

    def __init__(self, model: object, filters: FilterState | None, device: torch.device, dtype: torch.dtype) -> None:
        self._filters, self._device, self._dtype = filters, device, dtype
        rows = past_rows(model)
        self._past = Past(*rows) if any(rows) else None
        equations = equations_of(model)
        self._hidden = HiddenStates(equations) if equations is not None and equations.start else None
        self.reset()

    def reset(self) -> None:
        """Forget every row."""
        self._measured: ArrayLike | None = None
        self._inputs: ArrayLike | None = None
        for memory in (self._filters, self._past, self._hidden):
            if memory is not None:
                memory.reset()

    def see(self, state: ArrayLike, inputs: ArrayLike | None) -> None:
        """Note the state ``# (state,)`` on which the next command is sent, and what is held meanwhile."""
        self._measured, self._inputs = state, inputs

    def remember(self, sent: ArrayLike) -> None:
        """Add a row: the state seen last, and a command ``# (action,)``."""
        if self._filters is not None:
            command = torch.from_numpy(copy_of(sent, np.float64)).to(self._device, self._dtype)
            sent = self._filters.remember(command).cpu().numpy()
        if self._past is None and self._hidden is None:
            return
        reaching = copy_of(sent, np.float64)
        state, inputs = (None if seen is None else copy_of(seen, np.float64) for seen in (self._measured, self._inputs))
        if self._past is not None:
            self._past.remember(reaching, state)
        if self._hidden is not None and state is not None:
            self._hidden.advance(state, reaching, inputs)

    def memory(self) -> Tensor | None:
        """Of the filters as the kernel takes it; None before anything was sent."""
        if self._filters is None or not self._filters.memories:
            return None
        return single(memory_of(self._filters), self._device)

    def hidden(self) -> Tensor | None:
        """States that nobody measures ``# (hidden,)``; None where none have begun."""
        now = None if self._hidden is None else self._hidden.now
        return None if now is None else now.to(self._device, self._dtype)

    def past(self, state: ArrayLike) -> Tensor | None:
        """Of a state ``# (columns,)``; None before anything was sent, or for a model that does not see it."""
        before = None if self._past is None else self._past.before(copy_of(state, np.float64))
        return None if before is None else torch.from_numpy(before).to(self._device, self._dtype)
