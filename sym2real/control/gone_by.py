"""What MPPI keeps of the rows gone by: for command filters, hidden states, and a model that sees the past.

States that nobody measures (rotors still spin up for a command that was sent before) go on beneath the measured ones,
one step of the equations for every command that was sent::

    h' = f_h(s, h, a, inputs)

Plain torch, no TorchScript: that takes its time for the first calls, which happen in flight.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from numpy.typing import ArrayLike
from sympy import Expr
from torch import Tensor, nn

from sym2real.control.fused_arguments import copy_of, single
from sym2real.control.fused_filters import memory_of
from sym2real.effects.filters import FilterState, spelled_out
from sym2real.effects.visible import visible_state
from sym2real.past import Past, past_rows
from sym2real.symbolic import Equations, equations_of
from sym2real.symbolic.compile import build_function
from sym2real.trajectory import Array


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


class HiddenStates:
    """Hidden states of equations while commands are sent one by one.

    Args:
        equations: with hidden states, at the values that their parameters have now.

    Attributes:
        now: in double precision ``# (hidden,)``; None where they begin with the command that is sent next.
    """

    def __init__(self, equations: Equations) -> None:
        self._visible, self._inputs = visible_state(equations), len(equations.layouts.inputs)
        self._begin = _function(equations, equations.start, self._visible.columns)
        following = {column: equations.next[column] for column in equations.start}
        self._following = _function(equations, following, equations.layouts.state.columns)
        self.reset()

    def reset(self) -> None:
        """Forget every command."""
        self.now: Tensor | None = None

    @torch.no_grad()
    def advance(self, state: Array, reaching: Array, inputs: Array | None = None) -> None:
        """Go on by one step; what a state that is not finite (a lost pose) leaves unknown stays as it was.

        Args:
            state: measured, on which the command was sent ``# (visible,)``.
            reaching: what of the command reaches the robot ``# (action,)``.
            inputs: held meanwhile ``# (inputs,)``; None for zeros.
        """
        measured, command = self._visible.normalise(torch.as_tensor(state)), torch.as_tensor(reaching)
        known = torch.as_tensor(np.zeros(self._inputs) if inputs is None else inputs)
        held = (known,) if self._inputs else ()
        before = self._begin(measured, command, *held) if self.now is None else self.now
        after = self._following(torch.cat([measured, before]), command, *held)
        kept = torch.where(after.isfinite(), after, before)
        self.now = kept if bool(kept.isfinite().all()) else None


def _function(equations: Equations, expressions: Mapping[str, Expr], state: Sequence[str]) -> nn.Module:
    """Of a state of these columns, an action and inputs, where there are any."""
    groups = [state, equations.layouts.action.columns, equations.layouts.inputs.columns]
    over = [columns for columns in groups if columns]
    return build_function([spelled_out(equations, expression) for expression in expressions.values()], over)
