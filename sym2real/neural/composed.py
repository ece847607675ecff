"""A frozen base with a residual on top; the base is equations or an ensemble::

s' = normalise(f(s, a, inputs) + r(s, a, past))

Where equations have command filters, the residual's commands, present and past, are those that come out of them.
"""

import copy
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn.functional import pad

from sym2real.effects.filters import hidden_along, with_hidden_start
from sym2real.effects.visible import visible_state
from sym2real.errors import ShapeError
from sym2real.layout import Layout, Layouts
from sym2real.neural.ensemble import Ensemble
from sym2real.neural.manifold import manifold_of
from sym2real.neural.residual_mlp import ResidualMLP, joined
from sym2real.neural.symbolic_residual import SymbolicResidual
from sym2real.symbolic import Equations, build_module, compile_model, read_back
from sym2real.symbolic.compile import script
from sym2real.symbolic.predicting import Predicting

Base = Equations | Ensemble
Residual = ResidualMLP | SymbolicResidual


class _Step(nn.Module):
    """The composition as TorchScript takes it: one step, and many."""

    def __init__(self, base: nn.Module, residual: Residual, layouts: Layouts, dt: float) -> None:
        super().__init__()
        self.base, self.residual, self.visible = base, residual, len(residual.columns[0])
        self.manifold, self.dt = manifold_of(layouts.state), dt
        self.time = layouts.inputs.index("t") if "t" in layouts.inputs else -1
        self.inputs = len(layouts.inputs)
        self.commands = residual.commands * len(residual.columns[1])
        self.states = residual.states * self.visible

    def forward(
        self, state: Tensor, action: Tensor, inputs: Tensor | None = None, past: Tensor | None = None
    ) -> Tensor:
        seen = self.residual(state[..., : self.visible], action, past)
        following = self.base(state, action, inputs) + pad(seen, [0, state.shape[-1] - self.visible])
        on_manifold: Tensor = self.manifold(following)
        return on_manifold

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
            if inputs is None and k > 0 and self.time >= 0:  # the base has said at the first step what must be given
                known = state.new_zeros(self.inputs)
            if known is not None:
                if known.dim() >= actions.dim():
                    known = known[..., k, :]
                elif self.time >= 0:
                    known = known.clone()
                    known[..., self.time] += k * self.dt
            before, action = state, actions[..., k, :]
            state = self.forward(before, action, known, past)
            states.append(state)
            if self.commands + self.states > 0:
                past = self.moved(self.repeated(before, action) if past is None else past, before, action)
        return torch.stack(states, -2)


def state_of(base: Base) -> Layout:
    """The state columns that a log holds."""
    return visible_state(base) if isinstance(base, Equations) else base.layouts.state


class Composed(Predicting, nn.Module):
    """A dynamics model: a base plus a residual.

    Args:
        base: equations or an ensemble. Hidden states of equations (motor lag) begin where they say with every rollout,
            unless the start has them; the residual neither sees nor changes them.
        residual: over the same columns of state and action that a log holds.
        dtype: of both.

    Raises:
        ShapeError: when the columns differ.
    """

    def __init__(self, base: Base, residual: Residual, dtype: torch.dtype = torch.float32) -> None:
        super().__init__()
        self.layouts = Layouts(state_of(base), base.layouts.action, base.layouts.inputs)
        if residual.columns != (self.layouts.state.columns, self.layouts.action.columns):
            raise ShapeError(f"the residual is over {residual.columns}, the base over other columns")
        self._equations, self._visible = base if isinstance(base, Equations) else None, len(self.layouts.state)
        # Copies: what is done to one model, its precision too, is not done to another.
        if isinstance(base, Equations):
            self.base: nn.Module = compile_model(base, dtype=dtype)
        else:
            self.base = copy.deepcopy(base).to(dtype).requires_grad_(requires_grad=False)
        self.residual = copy.deepcopy(residual).to(dtype)
        self.scripted = script(self._step(self.base))

    def _step(self, base: nn.Module) -> _Step:
        return _Step(base, self.residual, self.below.layouts, self.below.dt)

    def plain(self) -> nn.Module:
        """One step as a module that is not scripted, for ``torch.export``."""
        equations = self.equations
        return self._step(self.base if equations is None else build_module(equations).float())

    @property
    def equations(self) -> Equations | None:
        """The base, with the values that it has now; None where it is an ensemble."""
        if self._equations is None or not self._equations.parameters:
            return self._equations
        return read_back(self.base, self._equations)

    @property
    def below(self) -> Base:
        """What lies below the residual."""
        return self.equations or cast(Ensemble, self.base)

    @property
    def past_rows(self) -> tuple[int, int]:
        """How many past commands and states it sees."""
        return self.residual.commands, self.residual.states

    def forward(
        self, state: Tensor, action: Tensor, inputs: Tensor | None = None, past: Tensor | None = None
    ) -> Tensor:
        """Next state ``# (..., n)``, as a log holds it; leading dimensions broadcast; ``past`` as of the residual."""
        following: Tensor = self.scripted(self._whole(state, action, inputs), action, inputs, past)
        return following[..., : self._visible]

    def _whole(self, state: Tensor, action: Tensor, inputs: Tensor | None) -> Tensor:
        return state if self._equations is None else with_hidden_start(self._equations, state, action, inputs)

    def hidden_along(self, states: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Hidden states in every row of a measured stretch ``# (..., T, hidden)``, with which rollouts may start."""
        if self._equations is None:
            return states[..., :0]
        return hidden_along(self._equations, self.base, states, actions, inputs)

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
        states: Tensor = self.scripted.rollout(self._whole(state, actions[..., 0, :], first), actions, inputs, past)
        return states[..., : self._visible]
