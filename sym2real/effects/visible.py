"""A compiled model as logs and controllers see it: hidden states start where the equations say and stay inside."""

from __future__ import annotations

from copy import copy
from functools import lru_cache

import torch
from torch import Tensor

from sym2real.effects.filters import hidden_along, with_hidden_start
from sym2real.layout import Layout
from sym2real.protocols import WholeModel
from sym2real.symbolic import Equations, compile_model, rollout


def visible_state(model: Equations | WholeModel) -> Layout:
    """The state columns that a log holds."""
    return Layout(tuple(field for field in model.layouts.state.fields if not field.hidden))


class VisibleModel:
    """A model of the visible columns.

    Hidden states (motor lag) begin anew with every rollout, unless the start has them: see :meth:`hidden_along`.

    Args:
        equations: with or without hidden states; their command filters are not applied here.
        dtype: of the rollouts.
    """

    def __init__(self, equations: Equations, dtype: torch.dtype = torch.float32) -> None:
        self.equations = equations
        self.columns = visible_state(equations).size
        self.compiled = compile_model(equations, dtype=dtype)
        self._values: Tensor | None = None  # those that were compiled

    def at(self, equations: Equations) -> VisibleModel:
        """The same of equations that differ in values of their parameters alone: nothing is compiled anew."""
        other = copy(self)
        other.equations = equations
        other._values = torch.tensor(list(equations.parameters.values()), dtype=self.compiled.values.dtype)
        return other

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """State ``# (..., visible)`` after one action ``# (..., action)``."""
        return self.rollout(state, action[..., None, :], None if inputs is None else inputs[..., None, :])[..., 0, :]

    def after_each(self, states: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        """States ``# (..., H, visible)`` one step after each of a measured stretch, hidden ones going on within it."""
        return self(torch.cat([states, self.hidden_along(states, actions, inputs)], dim=-1), actions, inputs)

    def hidden_along(self, states: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Hidden states in every row of a measured stretch ``# (..., T, hidden)``, with which rollouts may start."""
        return hidden_along(self.equations, self._step, states, actions, inputs)

    def _step(self, state: Tensor, action: Tensor, inputs: Tensor | None) -> Tensor:
        return rollout(self.compiled, state, action[..., None, :], inputs, self._values)[..., 0, :]

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (..., H, visible)`` after each action ``# (..., H, action)``; inputs as of ``rollout``.

        The start may have its hidden states ``# (..., n)``.
        """
        first = inputs
        if inputs is not None and inputs.dim() >= actions.dim():
            first = inputs[..., 0, :]
        start = with_hidden_start(self.equations, state, actions[..., 0, :], first)
        given = self._values if parameters is None else parameters
        return rollout(self.compiled, start, actions, inputs, given)[..., : self.columns]


def hidden_rows(model: object, states: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
    """Hidden states of any model in every row of a measured stretch ``# (..., T, hidden)``; none of most."""
    along = getattr(model, "hidden_along", None)
    return states[..., :0] if along is None else along(states, actions, inputs)


@lru_cache(maxsize=32)
def visible_in_double(equations: Equations) -> VisibleModel:
    """The model in float64; kept, because logs are held against the same equations again and again."""
    return VisibleModel(equations, torch.float64)
