"""What the sensors make of a state, and back: the way between a model's states and a log's or a controller's."""

import torch
from torch import Tensor

from sym2real.effects.filters import spelled_out
from sym2real.effects.visible import hidden_rows, visible_in_double, visible_state
from sym2real.past import past_rows
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations, compile_function, rollout, symbol

STEP = 1e-6  # of the tangent, for derivatives in double precision
# Of the tangent: where a report agrees with what was measured. Steps with one slope, and candidates of the slope.
AGREES, STEPS, SLOPES = 1e-11, 4, 3


class Sensors:
    """The static measurement effects of equations; those with memory are not among them.

    Args:
        equations: with ``output``; without, both ways are the identity.
    """

    def __init__(self, equations: Equations) -> None:
        self.layout = visible_state(equations)
        self._report = None
        self._inverse: Tensor | None = None
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
        """The states that are measured as ``measured`` ``# (..., visible)``; what is not finite comes back as it is.

        By Newton's method on the manifold. A slope does until its steps no longer lead there, from one call to the
        next: a controller asks in every period, and slopes are nearly all of the work.
        """
        if self._report is None or not measured.numel() or not bool(measured.isfinite().all()):
            return measured
        wanted = measured.double()
        state, inverse = wanted, self._inverse
        for _ in range(SLOPES):
            if inverse is None or inverse.shape[:-2] != wanted.shape[:-1]:
                inverse = self._inverse = self.inverse_slope(state)
            for _ in range(STEPS):
                away = self.layout.difference(self.measured(state), wanted)  # (..., tangent)
                if float(away.abs().max()) < AGREES:
                    return state.to(measured)
                state = self.layout.retract(state, -(inverse @ away[..., None])[..., 0])
            inverse = None
        return state.to(measured)

    def inverse_slope(self, state: Tensor) -> Tensor:
        """How states ``# (..., visible)`` follow what is measured, in tangents ``# (..., tangent, tangent)``."""
        size = self.layout.tangent_size
        unit = torch.eye(size, dtype=torch.float64).expand(*state.shape[:-1], size, size)
        if self._report is None:
            return unit
        moves = STEP * unit
        moved = self.layout.retract(state[..., None, :], moves)
        changes = self.layout.difference(self.measured(moved), self.measured(state)[..., None, :]) / STEP
        inverse: Tensor = torch.linalg.pinv(changes.mT)
        return inverse


class MeasuredModel:
    """A model of what is measured: starts and predictions are as the sensors report them.

    Args:
        equations: predict in float64; their command filters are not applied here.
        model: predicts instead of the equations that it has below, in its own precision.
    """

    def __init__(self, equations: Equations, model: DynamicsModel | None = None) -> None:
        self.model = model or visible_in_double(equations)
        self._sensors = Sensors(equations)
        self.past_rows = past_rows(model)
        self._sent = self.past_rows[0] * len(equations.layouts.action)

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Measured state ``# (..., visible)`` after one action ``# (..., action)``."""
        return self._sensors.measured(self.model(self._sensors.state(state), action, inputs))

    def rollout(
        self,
        state: Tensor,
        actions: Tensor,
        inputs: Tensor | None = None,
        parameters: Tensor | None = None,
        past: Tensor | None = None,
    ) -> Tensor:
        """Measured states ``# (..., H, visible)`` after each action; arguments as of ``rollout``."""
        visible, behind = len(self._sensors.layout), self._meant(past)
        start = torch.cat([self._sensors.state(state[..., :visible]), state[..., visible:]], dim=-1)
        return self._sensors.measured(rollout(self.model, start, actions, inputs, parameters, past=behind))

    def hidden_along(self, states: Tensor, actions: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Hidden states in every row of a measured stretch ``# (T, hidden)``, with which rollouts may start."""
        return hidden_rows(self.model, self._sensors.state(states), actions, inputs)

    def _meant(self, past: Tensor | None) -> Tensor | None:
        """The past with the states that were measured as those in it."""
        if past is None:
            return None
        sent, states = past[..., : self._sent], past[..., self._sent :]
        rows = states.unflatten(-1, (self.past_rows[1], self._sensors.layout.size))
        return torch.cat([sent, self._sensors.state(rows).flatten(-2)], dim=-1)
