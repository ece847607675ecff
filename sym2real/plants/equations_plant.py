"""Equations with all their effects as a plant: delays, lags, hidden states, time and sensors."""

from __future__ import annotations

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.effects.filters import FilterState, measurement_filters, with_hidden_start
from sym2real.effects.sensors import Sensors
from sym2real.effects.visible import visible_state
from sym2real.errors import ModelError
from sym2real.plants.model_plant import ModelPlant
from sym2real.robots import Robot
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Array


class EquationsPlant(ModelPlant):
    """A :class:`ModelPlant` that remembers from step to step what the equations need, and reports what sensors would.

    Args:
        equations: of the robot; states that the robot has not are hidden ones.
        robot: its columns and start.

    Raises:
        ModelError: where what is measured depends on the past, or an input is neither the robot's nor the time.
    """

    def __init__(self, equations: Equations, robot: Robot) -> None:
        late = [found.key for found, _ in measurement_filters(equations)]
        unknown = sorted({*equations.layouts.inputs} - {*robot.layouts.inputs, "t"})
        if late or unknown:
            raise ModelError(f"a model with {', '.join(late or unknown)} cannot be stepped as a plant")
        self._equations = equations
        self._compiled = compile_model(equations, dtype=torch.float64)
        self._filters, self._sensors = FilterState(equations), Sensors(equations)
        self._columns = visible_state(equations).size
        super().__init__(self._advance, robot, equations.dt)

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode, as if what is sent first had been held for ever; what sensors report ``# (state,)``."""
        super().reset(state, seed)
        self._filters.reset()
        self._hidden: Tensor | None = None
        self._steps = 0
        return self._reported()

    def step(self, action: ArrayLike) -> Array:
        """What sensors report ``# (state,)`` after one action ``# (action,)``."""
        super().step(action)
        return self._reported()

    def _advance(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        pushes = () if inputs is None else inputs.tolist()
        reaching = self._filters.apply(action[None, :])[0]
        self._filters.remember(action)
        known = {**dict(zip(self.layouts.inputs, pushes, strict=True)), "t": self._steps * self.dt}
        held = torch.tensor([known[name] for name in self._equations.layouts.inputs], dtype=torch.float64)
        if self._hidden is None:
            whole = with_hidden_start(self._equations, state, reaching, held)
        else:
            whole = torch.cat([state, self._hidden])
        after: Tensor = self._compiled(whole, reaching, held)
        self._hidden = after[self._columns :]
        self._steps += 1
        return after[: self._columns]

    def _reported(self) -> Array:
        measured: Array = self._sensors.measured(torch.as_tensor(self._state)).numpy().copy()
        return measured
