"""Equations with all their effects as a plant: delays, lags, hidden states, time and sensors."""

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
        equations: of the robot; their hidden states and a time go on inside.
        robot: its columns and start.

    Raises:
        ModelError: where what is measured depends on the past, an input is neither the robot's nor the time, or other
            columns than the robot's are measured or sent.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> plant = EquationsPlant(add(robot.nominal(), "delay:speed", {"value": 0.1}), robot)
        >>> start, standing = plant.reset(), plant.step([0.0, 0.0])
        >>> bool(abs(plant.step([0.0, 1.0])[4]) < 1e-9)  # the command is on its way
        True
    """

    def __init__(self, equations: Equations, robot: Robot) -> None:
        _require_steps(equations, robot)
        self._equations, self.description = equations, equations.to_json()  # what tells it from another plant
        self._compiled = compile_model(equations, dtype=torch.float64)
        self._filters, self._sensors = FilterState(equations), Sensors(equations)
        super().__init__(self._advance, robot)
        self.dt = equations.dt

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode, as if what is sent first had been held for ever; what sensors report ``# (state,)``."""
        self._filters.reset()
        self._hidden: Tensor | None = None
        self._steps = 0
        return self._reported(super().reset(state, seed))

    def step(self, action: ArrayLike) -> Array:
        """What sensors report ``# (state,)`` after one action ``# (action,)``."""
        return self._reported(super().step(action))

    def _advance(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        forces = () if inputs is None else inputs.tolist()
        reaching = self._filters.remember(action)
        known = {**dict(zip(self.layouts.inputs, forces, strict=True)), "t": self._steps * self.dt}
        held = torch.tensor([known[name] for name in self._equations.layouts.inputs], dtype=torch.float64)
        if self._hidden is None:
            whole = with_hidden_start(self._equations, state, reaching, held)
        else:
            whole = torch.cat([state, self._hidden])
        after: Tensor = self._compiled(whole, reaching, held)
        self._hidden = after[len(state) :]
        self._steps += 1
        return after[: len(state)]

    def _reported(self, state: Array) -> Array:
        return self._sensors.measured(torch.as_tensor(state)).numpy()


def _require_steps(equations: Equations, robot: Robot) -> None:
    late = [effect.key for effect, _ in measurement_filters(equations)]
    unknown = sorted({*equations.layouts.inputs} - {*robot.layouts.inputs, "t"})
    if late or unknown:
        raise ModelError(f"a model with {', '.join(late or unknown)} cannot be stepped as a plant")
    pairs = (visible_state(equations), robot.layouts.state), (equations.layouts.action, robot.layouts.action)
    for actual, expected in pairs:
        if actual.columns != expected.columns:
            own, its = (", ".join(layout.columns) for layout in (expected, actual))
            raise ModelError(f"expected a model of the {robot.name}'s columns {own}, found {its}")
