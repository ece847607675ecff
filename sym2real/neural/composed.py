"""Equations with a residual on top::

s' = normalise(f(s, a, inputs) + r(s, a))
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn.functional import pad

from sym2real.effects.filters import with_hidden_start
from sym2real.effects.visible import visible_state
from sym2real.errors import ShapeError
from sym2real.neural.residual_mlp import ResidualMLP, joined
from sym2real.symbolic import Equations, compile_model, read_back
from sym2real.symbolic.compile import script


class _Step(nn.Module):
    """The composition as TorchScript takes it: one step, and many."""

    def __init__(
        self,
        base: nn.Module,
        residual: ResidualMLP,
        visible: int,
        units: list[tuple[int, int]],
        dt_column: tuple[int, float],
    ):
        super().__init__()
        self.base, self.residual, self.visible = base, residual, visible
        self.units = units
        self.time, self.dt = dt_column
        self.commands = residual.commands * len(residual.columns[1])
        self.states = residual.states * visible

    def forward(
        self, state: Tensor, action: Tensor, inputs: Tensor | None = None, past: Tensor | None = None
    ) -> Tensor:
        seen = self.residual(state[..., : self.visible], action, past)
        following = self.base(state, action, inputs) + pad(seen, [0, state.shape[-1] - self.visible])
        parts = list(torch.unbind(following, -1))
        for first, last in self.units:
            length = torch.linalg.vector_norm(following[..., first:last], dim=-1).clamp(min=1e-12)
            for place in range(first, last):
                parts[place] = parts[place] / length
        return torch.stack(parts, -1)

    def repeated(self, state: Tensor, action: Tensor) -> Tensor:
        """The past that the first row has: itself."""
        return joined([action] * self.residual.commands + [state[..., : self.visible]] * self.residual.states)

    def moved(self, past: Tensor, state: Tensor, action: Tensor) -> Tensor:
        """The past of the next row, newest first."""
        commands = joined([action, past[..., : self.commands]])[..., : self.commands]
        states = joined([state[..., : self.visible], past[..., self.commands :]])[..., : self.states]
        return joined([commands, states])

    @torch.jit.export
    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, past: Tensor | None = None
    ) -> Tensor:
        states: list[Tensor] = []
        for k in range(actions.shape[-2]):
            known = inputs
            if inputs is not None:
                if inputs.dim() >= actions.dim():
                    known = inputs[..., k, :]
                elif self.time >= 0:
                    known = inputs.clone()
                    known[..., self.time] += k * self.dt
            before, action = state, actions[..., k, :]
            state = self.forward(before, action, known, past)
            states.append(state)
            if self.commands + self.states > 0:
                past = self.moved(self.repeated(before, action) if past is None else past, before, action)
        return torch.stack(states, -2)


class Composed(nn.Module):
    """A dynamics model: compiled equations plus a residual.

    Args:
        equations: the base. Its hidden states (motor lag) begin where it says with every rollout, and with every
            single step; the residual neither sees nor changes them.
        residual: over the same columns of state and action that a log holds.
        dtype: of both.

    Raises:
        ShapeError: when the columns differ.
    """

    def __init__(self, equations: Equations, residual: ResidualMLP, dtype: torch.dtype = torch.float32) -> None:
        super().__init__()
        layouts = equations.layouts
        visible = visible_state(equations).columns
        if residual.columns != (visible, layouts.action.columns):
            raise ShapeError(f"the residual is over {residual.columns}, the equations over other columns")
        self._visible = len(visible)
        self.base, self.residual = compile_model(equations, dtype=dtype), residual.to(dtype)
        self._equations = equations
        units = [
            (layouts.state.index(field.columns[0]), layouts.state.index(field.columns[0]) + len(field.columns))
            for field in layouts.state.fields
            if field.kind != "vector"
        ]
        time = layouts.inputs.index("t") if "t" in layouts.inputs else -1
        self._scripted = script(_Step(self.base, self.residual, len(visible), units, (time, equations.dt)))

    @property
    def equations(self) -> Equations:
        """The base, with the values that it has now."""
        return read_back(self.base, self._equations) if self._equations.parameters else self._equations

    @property
    def past_rows(self) -> tuple[int, int]:
        """How many past commands and states it sees."""
        return self.residual.commands, self.residual.states

    def forward(
        self, state: Tensor, action: Tensor, inputs: Tensor | None = None, past: Tensor | None = None
    ) -> Tensor:
        """Next state ``# (..., n)``, as a log holds it; leading dimensions broadcast; ``past`` as of the residual."""
        following: Tensor = self._scripted(self._whole(state, action, inputs), action, inputs, past)
        return following[..., : self._visible]

    def _whole(self, state: Tensor, action: Tensor, inputs: Tensor | None) -> Tensor:
        return with_hidden_start(self.equations, state, action, inputs) if self._equations.start else state

    def rollout(
        self,
        state: Tensor,
        actions: Tensor,
        inputs: Tensor | None = None,
        parameters: Tensor | None = None,
        past: Tensor | None = None,
    ) -> Tensor:
        """States ``# (..., H, n)`` after each action; operands as of :func:`sym2real.symbolic.rollout`.

        Actions and predicted states enter the past as the rollout goes on; without any, the first row is repeated.

        Raises:
            ShapeError: when parameter sets are given.
        """
        if parameters is not None:
            raise ShapeError("a model with a residual takes no parameter sets")
        first = inputs[..., 0, :] if inputs is not None and inputs.dim() >= actions.dim() else inputs
        states: Tensor = self._scripted.rollout(self._whole(state, actions[..., 0, :], first), actions, inputs, past)
        return states[..., : self._visible]
