"""Fixed text of the generated modules; ``$names`` are filled in by :mod:`sym2real.symbolic.source`.

``rollout`` keeps every column as a tensor of its own over all steps and stacks once at the end: half of the time of
a loop over ``forward``.
"""

from string import Template

HEAD = '''"""$about; needs torch and nothing else."""

from typing import List, Optional

import torch
from torch import Tensor


def tensors(numbers: Tensor, like: Tensor) -> List[Tensor]:
    """One tensor without dimensions per number, of the dtype and on the device of ``like``."""
    if numbers.numel() == 0:  # torch.export cannot save an unbind of nothing
        return []
    return list(torch.unbind(numbers.to(dtype=like.dtype, device=like.device), 0))


'''

MODEL = Template(
    HEAD
    + '''class Dynamics(torch.nn.Module):
    """Equations of one control period; columns are the last dimension, all leading dimensions broadcast.

    state      $state
    action     $action
    inputs     $inputs
    parameters $parameters
    """

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("values", torch.tensor($values, dtype=torch.float64))
        self.constants = torch.tensor($constants, dtype=torch.float64)

$methods

    def rows(
        self, state: Tensor, action: Tensor, inputs: Optional[Tensor], parameters: Optional[Tensor]
    ) -> List[Tensor]:
        """One tensor per parameter, in the state's dtype and on its device."""
        assert state.shape[-1] == $n, "expected the state columns $state"
        assert action.shape[-1] == $m, "expected the action columns $action"
        if inputs is None:
            assert $inputs_optional, "this model needs its inputs $inputs"
        else:
            assert inputs.shape[-1] == $k, "expected the input columns $inputs"
        if parameters is None:
            return tensors(self.values, state)
        assert parameters.shape[-1] == $p, "expected the parameters $parameters"
        return list(torch.unbind(torch.movedim(parameters, -1, 0).contiguous(), 0))

    def spread(self, state: Tensor, others: List[Tensor]) -> List[Tensor]:
        """State columns in the shape that all batch dimensions broadcast to."""
        like = state[..., 0]
        for other in others:
            like = torch.broadcast_tensors(like, other)[0]
        return list(torch.unbind(torch.movedim(state.expand(list(like.shape) + [$n]), -1, 0).contiguous(), 0))

    def forward(
        self, state: Tensor, action: Tensor, inputs: Optional[Tensor] = None, parameters: Optional[Tensor] = None
    ) -> Tensor:
        """Next state (..., $n) for state (..., $n), action (..., $m), inputs (..., $k), parameters (..., $p)."""
        held = inputs if inputs is None else inputs.unsqueeze(-2)
        return self.rollout(state, action.unsqueeze(-2), held, parameters).squeeze(-2)

    @torch.jit.export
    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Optional[Tensor] = None, parameters: Optional[Tensor] = None
    ) -> Tensor:
        """States (..., H, $n) after each of the actions (..., H, $m).

        Inputs with fewer dimensions than the actions (..., $k) are held, except t, which advances by $dt s a step;
        else they are given per step (..., H, $k).
        """
        values = self.rows(state, actions, inputs, parameters)
        steps = torch.movedim(actions, [-2, -1], [0, 1]).contiguous()
        per_step = torch.zeros(0)
        varying = False
        if inputs is None:
            held = [torch.zeros_like(state[..., 0])] * $k
        elif inputs.dim() < actions.dim():
            held = list(torch.unbind(torch.movedim(inputs, -1, 0).contiguous(), 0))
        else:
            assert inputs.shape[-2] == actions.shape[-2], "expected inputs for every step of the actions"
            varying = True
            per_step = torch.movedim(inputs, [-2, -1], [0, 1]).contiguous()
            held = list(torch.unbind(per_step[0], 0))
        columns = self.spread(state, [steps[0, 0]] + values[:1] + held[:1])
        shape = [steps.shape[0], $n] + list(columns[0].shape)
        fixed = self.hoist(values, tensors(self.constants, state))
        states: List[Tensor] = []
        for k in range(steps.shape[0]):
            now = list(torch.unbind(steps[k], 0))
            known = list(torch.unbind(per_step[k], 0)) if varying else list(held)
            $time
            columns = self.step(columns, now, known, fixed)
            states += columns
        return torch.movedim(torch.stack(states, 0).reshape(shape), [0, 1], [-2, -1])
'''
)

FUNCTION = Template(
    HEAD
    + '''class Function(torch.nn.Module):
    """Values (..., $n) of $n expression(s); columns are the last dimension, all leading dimensions broadcast."""

    def __init__(self) -> None:
        super().__init__()
        self.constants = torch.tensor($constants, dtype=torch.float64)

$methods

    def forward(self, $arguments) -> Tensor:
        """$columns"""
$checks
$unbind
        values = self.step($groups, self.hoist([], tensors(self.constants, a0)))
        return torch.movedim(torch.stack(torch.broadcast_tensors($values, $shapes)[:$n]), 0, -1)
'''
)
