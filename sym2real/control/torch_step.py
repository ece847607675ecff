"""One step of MPPI by torch: any model, any cost, any device and precision; what the kernels are held to."""

from collections.abc import Callable
from contextlib import nullcontext
from functools import cached_property

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control.at_steps import ReferenceTable
from sym2real.control.fused_arguments import copy_of
from sym2real.control.plan import Plan, importance_weights
from sym2real.effects.filters import FilterState
from sym2real.errors import ShapeError
from sym2real.protocols import DynamicsModel
from sym2real.robots.robot import Robot
from sym2real.symbolic import equations_of, rollout
from sym2real.symbolic.native_choice import torch_alone
from sym2real.symbolic.source import measured_inputs
from sym2real.tasks import Task
from sym2real.tasks.cost import running_cost

RunningCost = Callable[[Tensor, Tensor, Tensor], Tensor]


class TorchStep:
    """Rollouts, their costs and weights.

    Args:
        model: takes inputs; see :class:`~sym2real.control.MPPI`.
        robot: layouts, control period, and how it is sampled: horizon and temperature.
        task: reference and running cost.
        filters: what actions go through; None for none.
        kind: device and precision, of a tensor that has them.
        alone: without compiled rollouts, where torch was asked for.
    """

    def __init__(
        self,
        model: DynamicsModel,
        robot: Robot,
        task: Task,
        filters: FilterState | None,
        kind: Tensor,
        *,
        alone: bool,
    ) -> None:
        self.model, self.robot, self.task, self.filters = model, robot, task, filters
        self.horizon = max(1, round(robot.mppi.horizon / robot.dt))
        self.references = ReferenceTable(task, robot.dt, self.horizon, kind)
        self.device, self.dtype, self.alone = kind.device, kind.dtype, alone
        self._equations = equations_of(model)
        self._needed = () if self._equations is None else measured_inputs(self._equations)

    @cached_property
    def nothing(self) -> Tensor:
        """Inputs that are all zero, as many as the model's equations have."""
        size = 0 if self._equations is None else len(self._equations.layouts.inputs)
        return torch.zeros(size, dtype=self.dtype, device=self.device)

    @cached_property
    def cost(self) -> RunningCost:
        """The task's cost over a batch: states, actions, references → ``# (...,)``."""
        return running_cost(self.task, self.robot.layouts)

    def plan(
        self,
        state: ArrayLike,
        step: int,
        actions: Tensor,
        inputs: ArrayLike | None,
        *,
        past: Tensor | None = None,
        hidden: Tensor | None = None,
    ) -> Plan:
        """What comes of actions ``# (N, H, action)`` from a state at a step.

        Raises:
            ShapeError: for a cost that is another than a number for every sample and step; as of :meth:`rollout`.
        """
        states = self.rollout(state, actions, inputs, self.filters, past=past, hidden=hidden)
        costs, wanted = self.cost(states, actions, self.references.after(step)), actions.shape[:-1]
        if not isinstance(costs, Tensor) or costs.shape != wanted or not costs.is_floating_point():
            actual = f"{costs.dtype} {tuple(costs.shape)}" if isinstance(costs, Tensor) else type(costs).__name__
            expected = f"expected a tensor of floats {tuple(wanted)}"
            raise ShapeError(f"cost of task {self.task.name!r}: {expected}, found {actual}")
        costs = costs.sum(-1)
        costs = costs.masked_fill(~states.sum((-2, -1)).isfinite(), torch.inf)
        return Plan(states, actions, costs, importance_weights(costs, self.robot.mppi.temperature))

    def rollout(
        self,
        state: ArrayLike,
        actions: Tensor,
        inputs: ArrayLike | None,
        filters: FilterState | None,
        *,
        past: Tensor | None = None,
        hidden: Tensor | None = None,
    ) -> Tensor:
        """States ``# (N, H, state)`` after actions ``# (N, H, action)``, which go through the filters first.

        A model that sees the past is given ``past`` of the start ``# (columns,)``, one with hidden states begins with
        ``hidden`` ``# (hidden,)``; without, they begin with each sample's first action.

        Raises:
            ShapeError: for another number of states, and as of :meth:`given`.
        """
        start, known, size = self.tensor(state), self.given(inputs), len(self.robot.layouts.state)
        if start.shape != (size,):
            raise ShapeError(f"state: expected the shape ({size},), found {tuple(start.shape)}")
        start = self.robot.layouts.state.normalise(start)  # a measured quaternion, say
        if filters is not None:
            actions = filters.apply(actions)
        start = (start if hidden is None else torch.cat([start, hidden])).expand(len(actions), -1)
        with torch_alone() if self.alone else nullcontext():
            return rollout(self.model, start, actions, known, past=past, normalise=self.robot.layouts.state.normalise)

    def given(self, inputs: ArrayLike | None) -> Tensor | None:
        """Inputs as the model takes them; zero where none are given.

        Raises:
            ShapeError: for another number of inputs, or none where the model's equations use what is measured.
        """
        columns = () if self._equations is None else self._equations.layouts.inputs.columns
        if inputs is None:
            if self._needed:
                raise ShapeError(f"the model needs its inputs {' '.join(columns)}: {', '.join(self._needed)}")
            return None
        known = self.tensor(inputs)
        if self._equations is not None and known.shape != (len(columns),):
            raise ShapeError(f"inputs: expected the shape ({len(columns)},), found {tuple(known.shape)}")
        return known if known.numel() else None  # a plant without inputs says so by none of them

    def tensor(self, values: ArrayLike) -> Tensor:
        """A copy of numbers on the device, in the precision."""
        copied = values if isinstance(values, Tensor) else torch.from_numpy(copy_of(values, np.float64))
        return copied.to(self.device, self.dtype)
