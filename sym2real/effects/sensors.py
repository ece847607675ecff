"""What the sensors make of a state, and back: the way between a model's states and a log's or a controller's."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.effects.filters import spelled_out
from sym2real.effects.visible import VisibleModel, visible_state
from sym2real.symbolic import Equations, compile_function, symbol

STEP = 1e-6  # of the tangent, for derivatives in double precision
NEWTON_STEPS = 3


class Sensors:
    """The static measurement effects of equations; those with memory are not among them.

    Args:
        equations: with ``output``; without, both ways are the identity.
    """

    def __init__(self, equations: Equations) -> None:
        self.layout = visible_state(equations)
        self._report = None
        if equations.output:
            expressions = [equations.output.get(column, symbol(column)) for column in self.layout]
            self._report = compile_function(
                [spelled_out(equations, expression) for expression in expressions], [self.layout.columns]
            )

    def measured(self, state: Tensor) -> Tensor:
        """What is measured of states ``# (..., visible)``."""
        if self._report is None:
            return state
        reported: Tensor = self._report(state)
        return reported

    def state(self, measured: Tensor) -> Tensor:
        """The states that are measured as ``measured`` ``# (..., visible)``, by Newton's method on the manifold."""
        if self._report is None:
            return measured
        wanted, size = measured.double(), self.layout.tangent_size
        moves, state = STEP * torch.eye(size, dtype=torch.float64), wanted
        for _ in range(NEWTON_STEPS):
            away = self.layout.difference(self.measured(state), wanted)  # (..., tangent)
            moved = self.layout.retract(state[..., None, :], moves.expand(*state.shape[:-1], size, size))
            changes = self.layout.difference(self.measured(moved), self.measured(state)[..., None, :]) / STEP
            step = torch.linalg.lstsq(changes.mT, away[..., None]).solution[..., 0]
            state = self.layout.retract(state, -step)
        return state.to(measured)


class MeasuredModel:
    """A model of what is measured: starts and predictions are as the sensors report them.

    Args:
        equations: their command filters are not applied here.
        dtype: of the rollouts.
    """

    def __init__(self, equations: Equations, dtype: torch.dtype = torch.float64) -> None:
        self._sensors, self._visible = Sensors(equations), VisibleModel(equations, dtype)

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Measured state ``# (..., visible)`` after one action ``# (..., action)``."""
        return self._sensors.measured(self._visible(self._sensors.state(state), action, inputs))

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """Measured states ``# (..., H, visible)`` after each action; arguments as of ``rollout``."""
        return self._sensors.measured(self._visible.rollout(self._sensors.state(state), actions, inputs, parameters))
