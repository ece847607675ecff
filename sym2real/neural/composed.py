"""Equations with a residual on top::

s' = normalise(f(s, a, inputs) + r(s, a))
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from sym2real.errors import ModelError, ShapeError
from sym2real.neural.residual_mlp import ResidualMLP
from sym2real.symbolic import Equations, compile_model, read_back
from sym2real.symbolic.compile import script


class _Step(nn.Module):
    """The composition as TorchScript takes it: one step, and many."""

    def __init__(
        self, base: nn.Module, residual: nn.Module, units: list[tuple[int, int]], dt_column: tuple[int, float]
    ):
        super().__init__()
        self.base, self.residual = base, residual
        self.units = units
        self.time, self.dt = dt_column

    def forward(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        following = self.base(state, action, inputs) + self.residual(state, action)
        parts = list(torch.unbind(following, -1))
        for first, last in self.units:
            length = torch.linalg.vector_norm(following[..., first:last], dim=-1).clamp(min=1e-12)
            for place in range(first, last):
                parts[place] = parts[place] / length
        return torch.stack(parts, -1)

    @torch.jit.export
    def rollout(self, state: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        states: list[Tensor] = []
        for k in range(actions.shape[-2]):
            known = inputs
            if inputs is not None:
                if inputs.dim() >= actions.dim():
                    known = inputs[..., k, :]
                elif self.time >= 0:
                    known = inputs.clone()
                    known[..., self.time] += k * self.dt
            state = self.forward(state, actions[..., k, :], known)
            states.append(state)
        return torch.stack(states, -2)


class Composed(nn.Module):
    """A dynamics model: compiled equations plus a residual.

    Args:
        equations: the base; without hidden states.
        residual: over the same state and action columns.
        dtype: of both.

    Raises:
        ShapeError: when the columns differ.
        ModelError: for equations with hidden states, which a residual cannot see.
    """

    def __init__(self, equations: Equations, residual: ResidualMLP, dtype: torch.dtype = torch.float32) -> None:
        super().__init__()
        layouts = equations.layouts
        if residual.columns != (layouts.state.columns, layouts.action.columns):
            raise ShapeError(f"the residual is over {residual.columns}, the equations over other columns")
        if any(field.hidden for field in layouts.state.fields):
            raise ModelError("equations with hidden states take no residual: it would have to know them")
        self.base, self.residual = compile_model(equations, dtype=dtype), residual.to(dtype)
        self._equations = equations
        units = [
            (layouts.state.index(field.columns[0]), layouts.state.index(field.columns[0]) + len(field.columns))
            for field in layouts.state.fields
            if field.kind != "vector"
        ]
        time = layouts.inputs.index("t") if "t" in layouts.inputs else -1
        self._scripted = script(_Step(self.base, self.residual, units, (time, equations.dt)))

    @property
    def equations(self) -> Equations:
        """The base, with the values that it has now."""
        return read_back(self.base, self._equations) if self._equations.parameters else self._equations

    def forward(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Next state ``# (..., n)``; leading dimensions broadcast."""
        following: Tensor = self._scripted(state, action, inputs)
        return following

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (..., H, n)`` after each action; operands as of :func:`sym2real.symbolic.rollout`.

        Raises:
            ShapeError: when parameter sets are given.
        """
        if parameters is not None:
            raise ShapeError("a model with a residual takes no parameter sets")
        states: Tensor = self._scripted.rollout(state, actions, inputs)
        return states
