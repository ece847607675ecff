"""Model predictive path integral control over any dynamics model.

At each step: shift the mean of the last plan, add noise, roll the model out, weigh the rollouts by their cost::

    J_i = Σ_h c(s_h+1, a_h, s*_h+1),   w_i ∝ exp(-J_i / λ),   mean ← Σ_i w_i a_i

Sources: G. Williams et al., "Information theoretic MPC for model-based reinforcement learning", ICRA 2017;
the paper's section "Preliminary".
"""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from sym2real.control.noise import covariance_factor, sample, smoothing
from sym2real.control.timing import samples_within
from sym2real.control.weights import control_cost, weigh
from sym2real.effects.filters import FilterState
from sym2real.protocols import DynamicsModel
from sym2real.robots.robot import MPPISettings, Robot
from sym2real.symbolic import rollout
from sym2real.tasks import Task
from sym2real.tasks.cost import running_cost

Array = NDArray[np.float64]
RunningCost = Callable[[Tensor, Tensor, Tensor], Tensor]

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True)
class Plan:
    """What MPPI saw at one step: for plots, and for those who ask why it did what it did.

    Args:
        states: after each action, for every sample ``# (N, H, state)``.
        actions: ``# (N, H, action)``.
        costs: total cost of each sample, not finite where a rollout was thrown away ``# (N,)``.
        weights: ``# (N,)``.
    """

    states: Tensor
    actions: Tensor
    costs: Tensor
    weights: Tensor

    @property
    def rejected(self) -> int:
        """How many rollouts were not finite."""
        return int((~self.costs.isfinite()).sum())

    def best(self, count: int) -> Tensor:
        """States ``# (count, H, state)`` of the cheapest finite rollouts, best first; fewer where fewer are."""
        order = self.costs.nan_to_num(nan=torch.inf).argsort()[: min(count, len(self.costs) - self.rejected)]
        return self.states[order]


class MPPI:
    """A :class:`~sym2real.protocols.Controller` that plans with a model.

    Args:
        model: any dynamics model or plain ``(state, action)`` callable. One with a method ``rollout(state, actions,
            inputs, parameters)``, ``# (N, state), (N, H, action), (inputs,) or None, None`` → ``# (N, H, state)``, is
            rolled out by that: a compiled model, or a simulator that starts from more than the measured state.
        robot: layouts, limits, resting action and control period.
        task: reference and running cost.
        settings: the robot's where none are given.
        noise_covariance: ``# (action, action)`` instead of the settings' standard deviations.
        price_noise: adds the information-theoretic control cost (exact for white noise, no knots, no correlation).
        device: where the model lives.
        dtype: of the rollouts.
        seed: of the noise; :meth:`reset` goes back to it.
        filters: what commands go through on the way to the robot (delay, lag); none by default.
        period: seconds an action may take. Fewer samples are drawn where this machine cannot hold it, and the log
            says so.
    """

    def __init__(
        self,
        model: DynamicsModel | Callable[[Tensor, Tensor], Tensor],
        robot: Robot,
        task: Task,
        *,
        settings: MPPISettings | None = None,
        noise_covariance: ArrayLike | None = None,
        price_noise: bool = False,
        device: str | torch.device = "cpu",
        dtype: torch.dtype = torch.float32,
        seed: int = 0,
        filters: FilterState | None = None,
        period: float | None = None,
    ) -> None:
        self.model, self.robot, self.task = with_inputs(model), robot, task
        self.settings = settings or robot.mppi
        self.device, self.dtype, self.seed = torch.device(device), dtype, seed
        self.price_noise, self.filters = price_noise, filters
        self.horizon = max(1, round(self.settings.horizon / robot.dt))
        self.cost = running_cost(task, robot.layouts)
        self._factor = covariance_factor(self.settings.noise if noise_covariance is None else noise_covariance).to(
            self.device, dtype
        )
        self._smooth = smoothing(self.horizon, robot.dt, self.settings).to(self.device, dtype)
        self._low, self._high, self._rest = (self._tensor(v) for v in (robot.low, robot.high, robot.rest))
        self._generator = torch.Generator(self.device)
        self.samples = self.settings.samples
        self.reset()
        if period is not None:
            self.samples = samples_within(period, self.samples, self._trial)
            self.reset()

    def reset(self) -> None:
        """Forget the last plan and start the noise anew."""
        self._generator.manual_seed(self.seed)
        if self.filters is not None:
            self.filters.reset()
        self.mean = self._rest.repeat(self.horizon, 1)  # (H, action)
        self.plan: Plan | None = None
        self._step: int | None = None

    def remember(self, sent: ArrayLike) -> None:
        """Advance the memory of the command filters; without any there is nothing to note."""
        if self.filters is not None:
            self.filters.remember(self._tensor(sent))

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` within the limits, for a state ``# (state,)`` at time ``step · dt``.

        The plan is shifted by the steps since the last call, and refined in place where there are none.
        """
        if self._step is not None:
            self.mean = shift(self.mean, step - self._step)
        self._step = step
        self.improve(state, step, sample(self.samples, self._smooth, self._factor, self._generator), inputs)
        mean: Array = self.mean[0].to("cpu", torch.float64).numpy()
        return np.clip(mean, self.robot.low, self.robot.high)

    @torch.no_grad()
    def improve(self, state: ArrayLike, step: int, noise: Tensor, inputs: ArrayLike | None = None) -> Plan:
        """One update of :attr:`mean` with this noise ``# (N, H, action)``; what it saw is kept as :attr:`plan`."""
        actions = torch.clamp(self.mean + noise, self._low, self._high)
        states = self._rollout(state, actions, inputs)
        costs = self.cost(states, actions, self._reference(step)).sum(-1)
        if self.price_noise:
            costs = costs + control_cost(self.mean, actions - self.mean, self._factor, self.settings.temperature)
        costs = costs.masked_fill(~states.sum((-2, -1)).isfinite(), torch.inf)
        self.plan = Plan(states, actions, costs, weigh(costs, self.settings.temperature))
        if self.plan.rejected == len(costs):
            LOGGER.warning("MPPI: no rollout at step %d is finite, the last plan goes on", step)
        else:
            self.mean = torch.einsum("n,nha->ha", self.plan.weights, actions)
        return self.plan

    @torch.no_grad()
    def predict(self, state: ArrayLike, inputs: ArrayLike | None = None) -> Tensor:
        """States ``# (H, state)`` that the model expects under the present mean."""
        return self._rollout(state, self.mean[None], inputs)[0]

    def _rollout(self, state: ArrayLike, actions: Tensor, inputs: ArrayLike | None) -> Tensor:
        start = self._tensor(state).expand(len(actions), -1)
        known = None if inputs is None else self._tensor(inputs)
        if self.filters is not None:
            actions = self.filters.apply(actions)
        return rollout(self.model, start, actions, known, normalise=self.robot.layouts.state.normalise)

    def _reference(self, step: int) -> Tensor:
        steps = torch.arange(step + 1, step + 1 + self.horizon, dtype=torch.float64)
        return self.task.reference(steps * self.robot.dt).to(self.device, self.dtype)  # (H, state)

    def _tensor(self, values: ArrayLike) -> Tensor:
        return torch.as_tensor(np.asarray(values), dtype=self.dtype, device=self.device)

    def _trial(self, samples: int) -> None:
        noise = sample(samples, self._smooth, self._factor, self._generator)
        self.improve(self.robot.start, 0, noise)


def with_inputs(model: DynamicsModel | Callable[[Tensor, Tensor], Tensor]) -> DynamicsModel:
    """A model that takes inputs: a plain ``(state, action)`` callable is given none of them."""
    plain = not isinstance(model, torch.nn.Module) and not hasattr(model, "rollout")
    if plain and len(inspect.signature(model).parameters) == 2:
        return lambda state, action, inputs=None: model(state, action)
    return cast(DynamicsModel, model)


def shift(mean: Tensor, steps: int) -> Tensor:
    """A plan ``# (H, action)`` as it stands some steps later; its last action is repeated."""
    keep = mean[min(max(steps, 0), len(mean) - 1) :]
    return torch.cat([keep, keep[-1:].expand(len(mean) - len(keep), -1)])
