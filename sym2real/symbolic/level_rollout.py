"""Rollouts of few samples without a compiler: torch's own kernels, as few calls of them as there can be.

At a hundred samples an operation of torch takes no longer than calling it. So all operations of a kind and level are
one call: their operands are gathered by one index, and results go where the next level looks for them. The loop is
generated TorchScript; its memory is made once, for one number of samples.
"""

from __future__ import annotations

from string import Template

import torch
from torch import Tensor
from torch.jit._fuser import optimized_execution

from sym2real.symbolic.compile import class_from_source, script
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.levels import Levels, cut
from sym2real.symbolic.source import TIME, step_program
from sym2real.symbolic.torch_source import CALLS

FEW = 1024  # samples; of more, gathering operands takes longer than the calls it saves (measured)
HORIZON = Template('''"""Generated from a program of $levels levels; needs torch and nothing else."""

from typing import List

import torch
from torch import Tensor


class Horizon(torch.nn.Module):
    def forward(
        self, rows: Tensor, actions: List[Tensor], states: List[Tensor], own: List[Tensor], indices: List[Tensor],
        gathered: List[Tensor], operands: List[Tensor], results: List[Tensor]
    ) -> None:
        for h in range(len(actions)):
            own[1].copy_(actions[h])
$step
            torch.index_select(rows, 0, indices[$levels], out=states[h])
            own[0].copy_(states[h])
$clock
''')


class LevelRollout:
    """A model's rollout for one number of samples, level by level.

    Args:
        equations: with their parameter values; without hidden states.
        samples: N.
        horizon: H.

    Raises:
        ModelError: when the equations hold conditions.
    """

    def __init__(self, equations: Equations, samples: int, horizon: int) -> None:
        layouts, program = equations.layouts, step_program(equations)
        levels = cut(program)
        self.samples = samples
        self._rows = torch.zeros(levels.rows, samples)
        first = len(program.inputs)
        self._rows[first : first + len(levels.numbers)] = torch.tensor(levels.numbers)[:, None]
        known = first - len(equations.parameters)
        self._rows[known:first] = torch.tensor(list(equations.parameters.values()))[:, None]
        self._known = self._rows[len(layouts.state) + len(layouts.action) : known]
        state, actions = len(layouts.state), len(layouts.action)
        self._own = [self._rows[:state], self._rows[state : state + actions]]
        self._own += [self._known[layouts.inputs.index(TIME)]] if TIME in layouts.inputs else []
        self._states = torch.empty(horizon, state, samples)
        self._lists = _memory(levels, self._rows)
        self._horizon = script(class_from_source(_source(levels, equations), "Horizon")())

    def __call__(self, state: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        """States ``# (N, H, n)`` after each action ``# (N, H, m)``, from one state ``# (n,)``; inputs are held."""
        self._own[0].copy_(state[:, None].expand(-1, self.samples))
        self._known.copy_(torch.zeros(1) if inputs is None else inputs[:, None].expand(-1, self.samples))
        steps = list(actions.permute(1, 2, 0).contiguous())
        with torch.no_grad(), optimized_execution(False):
            self._horizon(self._rows, steps, list(self._states), self._own, *self._lists)
        return self._states.permute(2, 0, 1).clone()


def _memory(levels: Levels, rows: Tensor) -> tuple[list[Tensor], ...]:
    """Indices and gathered rows of each level, then operands and results of each batch."""
    indices, gathered, operands, results = list[Tensor](), list[Tensor](), list[Tensor](), list[Tensor]()
    reads = [[row for batch in level for read in batch.operands for row in read] for level in levels.batches]
    shared = torch.empty(max(map(len, reads), default=0), rows.shape[1])  # by all levels: it stays in the cache
    for level, index in zip(levels.batches, reads, strict=True):
        indices.append(torch.tensor(index))
        gathered.append(shared[: len(index)])
        sizes = [batch.size for batch in level for _ in batch.operands]
        operands += gathered[-1].split(sizes)
        results += [rows[batch.first : batch.first + batch.size] for batch in level]
    return [*indices, torch.tensor(levels.outputs)], gathered, operands, results


def _source(levels: Levels, equations: Equations) -> str:
    lines, operand, result = list[str](), 0, 0
    for number, level in enumerate(levels.batches):
        lines.append(f"torch.index_select(rows, 0, indices[{number}], out=gathered[{number}])")
        for batch in level:
            count = len(batch.operands)
            given = ", ".join(f"operands[{operand + i}]" for i in range(count))
            lines.append(f"{CALLS.get(batch.kind, 'torch.' + batch.kind)}({given}, out=results[{result}])")
            operand, result = operand + count, result + 1
    step = "\n".join(" " * 12 + line for line in lines)
    clock = f"            own[2].add_({equations.dt!r})" if TIME in equations.layouts.inputs else ""
    return HORIZON.substitute(step=step, levels=len(levels.batches), clock=clock)
