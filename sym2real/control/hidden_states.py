"""States that nobody measures, between actions: rotors still spin up for a command that was sent before.

They go on beneath the measured states, one step of the equations for every command that was sent::

    h' = f_h(s, h, a, inputs)

Plain torch, no TorchScript: that takes its time for the first calls, which happen in flight.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from sympy import Expr
from torch import Tensor, nn

from sym2real.effects.filters import spelled_out
from sym2real.effects.visible import visible_state
from sym2real.symbolic import Equations
from sym2real.symbolic.compile import build_function
from sym2real.trajectory import Array


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
