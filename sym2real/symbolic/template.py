"""Fixed text of the generated modules; ``$names`` are filled in by :mod:`sym2real.symbolic.source`.

``rollout`` keeps every column as a tensor of its own over all steps and stacks once at the end: half of the time of
a loop over ``forward``.
"""

from string import Template

MODEL = Template('''"""$title: next state after $dt s, generated from its equations; needs torch and nothing else."""

from typing import List, Optional

import torch
from torch import Tensor


class Dynamics(torch.nn.Module):
    """Equations of one control period; columns are the last dimension, all leading dimensions broadcast.

    state      $state
    action     $action
    inputs     $inputs
    parameters $parameters
    """

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("values", torch.tensor($values, dtype=torch.float64))

$methods

    def rows(self, state: Tensor, action: Tensor, inputs: Optional[Tensor], parameters: Optional[Tensor]) -> List[Tensor]:
        """One tensor per parameter, in the state's dtype and on its device."""
        assert state.shape[-1] == $n, "expected the state columns $state"
        assert action.shape[-1] == $m, "expected the action columns $action"
        if inputs is None:
            assert $inputs_optional, "this model needs its inputs $inputs"
        else:
            assert inputs.shape[-1] == $k, "expected the input columns $inputs"
        if parameters is None:
            return list(torch.unbind(self.values.to(state), 0))
        assert parameters.shape[-1] == $p, "expected the parameters $parameters"
        return list(torch.unbind(torch.movedim(parameters, -1, 0).contiguous(), 0))

    def spread(self, state: Tensor, others: List[Tensor]) -> List[Tensor]:
        """State columns in the shape that all batch dimensions broadcast to."""
        batch = list(torch.broadcast_tensors([state[..., 0]] + others)[0].shape)
        return list(torch.unbind(torch.movedim(state.expand(batch + [$n]), -1, 0).contiguous(), 0))

    def forward(
        self, state: Tensor, action: Tensor, inputs: Optional[Tensor] = None, parameters: Optional[Tensor] = None
    ) -> Tensor:
        """Next state (..., $n) for state (..., $n), action (..., $m), inputs (..., $k), parameters (..., $p)."""
        if inputs is not None and inputs.shape[-1] == 0:
            inputs = None
        values = self.rows(state, action, inputs, parameters)
        actions = list(torch.unbind(torch.movedim(action, -1, 0), 0))
        if inputs is None:
            columns = self.spread(state, actions[:1] + values[:1])
            known = [torch.zeros_like(columns[0])] * $k
            after = self.step(columns, actions, known, self.hoist(values, columns[0]))
        else:
            known = list(torch.unbind(torch.movedim(inputs, -1, 0), 0))
            columns = self.spread(state, actions[:1] + values[:1] + known[:1])
            after = self.step$pushed(columns, actions, known, self.hoist$pushed(values, columns[0]))
        return torch.movedim(torch.stack(after, 0), 0, -1)

    @torch.jit.export
    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Optional[Tensor] = None, parameters: Optional[Tensor] = None
    ) -> Tensor:
        """States (..., H, $n) after each of the actions (..., H, $m).

        Inputs with fewer dimensions than the actions (..., $k) are held, except t, which advances by $dt s a step;
        else they are given per step (..., H, $k).
        """
        if inputs is not None and inputs.shape[-1] == 0:
            inputs = None
        values = self.rows(state, actions, inputs, parameters)
        steps = torch.movedim(actions, [-2, -1], [0, 1]).contiguous()
        others = [steps[0, 0]] + values[:1]
        per_step = torch.zeros(0)
        held: List[Tensor] = []
        varying = False
        if inputs is not None:
            varying = inputs.dim() >= actions.dim()
            if varying:
                assert inputs.shape[-2] == actions.shape[-2], "expected inputs for every step of the actions"
                per_step = torch.movedim(inputs, [-2, -1], [0, 1]).contiguous()
                others.append(per_step[0, 0])
            else:
                held = list(torch.unbind(torch.movedim(inputs, -1, 0).contiguous(), 0))
                others.append(held[0])
        columns = self.spread(state, others)
        shape = [steps.shape[0], $n] + list(columns[0].shape)
        states: List[Tensor] = []
        if inputs is None:
            fixed = self.hoist(values, columns[0])
            known = [torch.zeros_like(columns[0])] * $k
            for k in range(steps.shape[0]):
$advance_known
                columns = self.step(columns, list(torch.unbind(steps[k], 0)), known, fixed)
                states += columns
        else:
            fixed = self.hoist$pushed(values, columns[0])
            for k in range(steps.shape[0]):
                if varying:
                    known = list(torch.unbind(per_step[k], 0))
                else:
                    known = list(held)
$advance_held
                columns = self.step$pushed(columns, list(torch.unbind(steps[k], 0)), known, fixed)
                states += columns
        return torch.movedim(torch.stack(states, 0).reshape(shape), [0, 1], [-2, -1])
''')

FUNCTION = Template('''"""Function generated from expressions; needs torch and nothing else."""

from typing import List

import torch
from torch import Tensor


class Function(torch.nn.Module):
    """Values (..., $n) of $n expression(s); columns are the last dimension, all leading dimensions broadcast."""

$methods

    def forward(self, $arguments) -> Tensor:
        """$columns"""
$checks
$unbind
        values = self.step($groups, self.hoist([], $first))
        return torch.stack(torch.broadcast_tensors(values + [$shapes])[:$n], -1)
''')
