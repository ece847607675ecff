"""MPPI as a model asks for it: its command filters, the state that its sensors mean, the inputs that it has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.control.mppi import MPPI
from sym2real.effects.filters import FilterState, command_filters, measurement_filters
from sym2real.effects.inputs import TIME
from sym2real.effects.sensors import Sensors
from sym2real.effects.visible import VisibleModel
from sym2real.errors import ModelError
from sym2real.protocols import DynamicsModel
from sym2real.robots.robot import Robot
from sym2real.symbolic import Equations, equations_of
from sym2real.tasks import Task
from sym2real.trajectory import Array


def mppi_controller(
    model: Equations | DynamicsModel,
    robot: Robot,
    task: Task,
    *,
    samples: int | None = None,
    seed: int = 0,
    period: float | None = None,
) -> MPPI | CorrectedMPPI:
    """MPPI with a model and the robot's sampling, with another number of samples where one is given.

    Where the model's equations hold measurement effects, MPPI receives the state without them, so that references keep
    their meaning; where their inputs are others than the robot's (a time, or none at all), those that they have. A
    model that is not made of equations has neither, and no command filters.

    Raises:
        ModelError: for equations whose measurements have memory, which cannot be undone.
    """
    flown = VisibleModel(model) if isinstance(model, Equations) else model
    equations = equations_of(flown)
    settings = robot.mppi if samples is None else replace(robot.mppi, samples=samples)
    if equations is None:
        return MPPI(flown, robot, task, settings=settings, seed=seed, period=period)
    late = [effect.key for effect, _ in measurement_filters(equations)]
    if late:
        raise ModelError(f"{', '.join(late)} cannot be undone step by step: control needs the present state")
    filters = FilterState(equations) if command_filters(equations) else None
    mppi = MPPI(flown, robot, task, settings=settings, seed=seed, filters=filters, period=period)
    same = not equations.output and equations.layouts.inputs.columns == robot.layouts.inputs.columns
    return mppi if same else CorrectedMPPI(mppi, equations)


class CorrectedMPPI:
    """MPPI that is given the state that the sensors mean, and the inputs that its equations have.

    Args:
        controller: knows nothing of the sensors, and of the equations' inputs alone.
        equations: say what the sensors report, and name the inputs.
    """

    def __init__(self, controller: MPPI, equations: Equations) -> None:
        self._controller, self._sensors = controller, Sensors(equations)
        self._wanted, self._given = equations.layouts.inputs.columns, controller.robot.layouts.inputs.columns
        self.reset, self.remember = controller.reset, controller.remember

    @property
    def samples(self) -> int:
        """Of the controller."""
        return self._controller.samples

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)`` and the robot's inputs ``# (inputs,)``."""
        measured = torch.as_tensor(np.asarray(state, dtype=np.float64))
        return self._controller.act(self._sensors.state(measured).numpy(), step, self._known(step, inputs))

    def _known(self, step: int, inputs: ArrayLike | None) -> ArrayLike | None:
        """By name; what neither the robot nor the clock gives is left to the controller to miss."""
        held = np.zeros(len(self._given)) if inputs is None else np.asarray(inputs, dtype=np.float64)
        known = {**dict(zip(self._given, held, strict=False)), TIME: step * self._controller.robot.dt}
        return np.array([known[name] for name in self._wanted]) if known.keys() >= set(self._wanted) else inputs
