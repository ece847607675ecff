"""Any dynamics model as a plant."""

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.effects.along_logs import precision_of
from sym2real.errors import ShapeError
from sym2real.layout import Layouts
from sym2real.past import Past, past_rows
from sym2real.protocols import DynamicsModel
from sym2real.robots import Robot
from sym2real.symbolic import Equations
from sym2real.trajectory import Array


class ModelPlant:
    """A :class:`~sym2real.protocols.Plant` that steps a model.

    Crashed once the state is not finite or its height ``z`` is below zero.

    Args:
        model: next state ``# (state,)`` from state, action and inputs, and the past where it sees one (``past_rows``).
        robot: that the model describes; gives columns, start and control period.

    Raises:
        ShapeError: when a compiled model has other columns: hidden states and a time have to go on from step to step,
            as :class:`~sym2real.plants.EquationsPlant` lets them.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> plant = ModelPlant(compile_model(robot.nominal()), robot)
        >>> plant.reset().shape
        (7,)
    """

    def __init__(self, model: DynamicsModel, robot: Robot) -> None:
        self.model, self.robot, self.layouts, self.dt = model, robot, robot.layouts, robot.dt
        _require_columns(model, robot.layouts)
        self._dtype = precision_of(model)
        self._past = Past(*past_rows(model))
        self.reset()

    @property
    def inputs(self) -> Array:
        """What is held now ``# (inputs,)``."""
        return self._inputs.copy()

    @property
    def crashed(self) -> bool:
        """Whether the state is not finite, or below the ground."""
        if not np.isfinite(self._state).all():
            return True
        return "z" in self.layouts.state and bool(self._state[self.layouts.state.index("z")] < 0.0)

    @property
    def sent(self) -> Array:
        """The last action; nothing limits it ``# (action,)``."""
        return self._sent.copy()

    def push(self, inputs: ArrayLike) -> None:
        """Hold inputs until the next call or reset ``# (inputs,)``."""
        self._inputs = _checked(inputs, self.layouts.inputs.columns)

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode at ``state`` or the robot's start; nothing is random, so the seed has no effect."""
        self._state = _checked(self.robot.start if state is None else state, self.layouts.state.columns)
        self._inputs = np.zeros(self.layouts.inputs.size)
        self._sent = np.full(self.layouts.action.size, np.nan)
        self._past.reset()
        return self._state.copy()

    @torch.no_grad()
    def step(self, action: ArrayLike) -> Array:
        """State ``# (state,)`` after one action ``# (action,)``."""
        self._sent = _checked(action, self.layouts.action.columns)
        past = self._past.before(self._state)
        behind = () if past is None else (self._tensor(past),)
        after = self.model(self._tensor(self._state), self._tensor(self._sent), self._tensor(self._inputs), *behind)
        self._past.remember(self._sent, self._state)
        self._state = self.layouts.state.normalise(after.double()).numpy()
        return self._state.copy()

    def _tensor(self, values: Array) -> Tensor:
        return torch.as_tensor(values, dtype=self._dtype)


def _require_columns(model: object, layouts: Layouts) -> None:
    equations = getattr(model, "equations", None)
    if not (isinstance(model, torch.jit.ScriptModule) and isinstance(equations, Equations)):
        return
    for group, layout in layouts.groups.items():
        mine, its = layout.columns, equations.layouts.groups[group].columns
        if mine != its:
            raise ShapeError(
                f"a ModelPlant of the {group} columns {mine} cannot step a model of {its}; an EquationsPlant can"
            )


def _checked(values: ArrayLike, columns: tuple[str, ...]) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != (len(columns),):
        raise ShapeError(f"expected one number for each of {columns}, found shape {array.shape}")
    return array
