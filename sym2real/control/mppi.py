"""Model predictive path integral control over any dynamics model.

At each step: shift the mean of the last plan, add noise, roll the model out, weight the rollouts by their cost::

    J_i = Σ_h c(s_h+1, a_h, s*_h+1),   w_i ∝ exp(-J_i / λ),   mean ← Σ_i w_i a_i

Equations with a cost that is an expression are planned with in one fused kernel (:mod:`sym2real.control.fused`);
torch does the same for any model, and is what the kernel is tested against.

Sources: G. Williams et al., "Information theoretic MPC for model-based reinforcement learning", ICRA 2017;
the paper's section "Preliminary".
"""

import logging
import time
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.control.backend import (
    NO_COMPILER,
    Backend,
    choose,
    device_of,
    fused_step,
    planned_with,
    require_choices,
    why_not_fused,
)
from sym2real.control.fused import FusedStep
from sym2real.control.fused_arguments import Call, Sizes, single
from sym2real.control.fused_gpu import FusedGpuStep
from sym2real.control.gone_by import GoneBy
from sym2real.control.noise import deviations, require_steps, sample, smoothing
from sym2real.control.plan import Plan, importance_weights, shift
from sym2real.control.timing import samples_within
from sym2real.control.torch_step import TorchStep
from sym2real.effects.filters import FilterState
from sym2real.protocols import DynamicsModel
from sym2real.robots.robot import MPPISettings, Robot
from sym2real.tasks import Task
from sym2real.trajectory import Array

LOGGER = logging.getLogger(__name__)
Draws = Callable[[int], Tensor]


class MPPI:
    """A :class:`~sym2real.protocols.Controller` that plans with a model.

    Args:
        model: any dynamics model or plain ``(state, action)`` callable. One with a method ``rollout(state, actions,
            inputs, parameters)``, ``# (N, state), (N, H, action), (inputs,) or None, None`` → ``# (N, H, state)``, is
            rolled out by that: a compiled model, or a simulator that starts from more than the measured state.
        robot: layouts, limits, resting action and control period.
        task: reference and running cost.
        settings: the robot's where none are given.
        device, dtype: where the model lives; of the rollouts.
        seed: of the noise; :meth:`reset` goes back to it.
        filters: what commands go through on the way to the robot (delay, lag); none by default.
        period: seconds an action may take. Fewer samples are drawn where this machine cannot hold it, and the log
            says so. Without a compiler it is the robot's control period by default.
        backend: "c" (the fused kernel: C, or CUDA on a GPU), "torch" or "auto": the kernel where it can be (logged).
        draws: noise ``# (N, H, action)`` by the number of the action, counted from 1, in place of torch's own: with the
            :attr:`draws` of another controller, two models are compared on the same noise. The kernel draws its own.

    Raises:
        ModelError: when ``backend="c"`` cannot plan with this model, with the reason; for a device that is not here.
        ShapeError: for noise of other actions, a period that is not positive.
        UnknownNameError: for a backend that does not exist.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> controller = MPPI(compile_model(robot.nominal()), robot, make_task("circle", robot))
        >>> controller.act(robot.start, step=0).shape
        (2,)
    """

    def __init__(
        self,
        model: DynamicsModel | Callable[[Tensor, Tensor], Tensor],
        robot: Robot,
        task: Task,
        *,
        settings: MPPISettings | None = None,
        device: str | torch.device = "cpu",
        dtype: torch.dtype = torch.float32,
        seed: int = 0,
        filters: FilterState | None = None,
        period: float | None = None,
        backend: Backend = "auto",
        draws: Draws | None = None,
    ) -> None:
        self.period = robot.dt if period is None else period
        self.missed = 0  # actions that took longer than the period
        require_choices(backend, self.period)
        self.model, self.robot, self.task = planned_with(model, dtype), robot, task
        self.settings = settings or robot.mppi
        self.device, self.dtype, self.seed = device_of(device), dtype, int(seed)
        self.filters, self._given = filters, draws
        self._gone_by = GoneBy(self.model, filters, self.device, dtype)
        self._spread = deviations(self.settings.noise, len(robot.layouts.action)).to(self.device, dtype)
        sampled, alone = replace(robot, mppi=self.settings), backend == "torch"
        self._torch = TorchStep(self.model, sampled, task, filters, self._spread, alone=alone)
        self.horizon = self._torch.horizon
        self._smooth = smoothing(self.horizon, robot.dt, self.settings).to(self.device, dtype)
        self._low, self._high, self._rest = map(self._torch.tensor, (robot.low, robot.high, robot.rest))
        self._generator = torch.Generator(self.device)
        self.samples = self.settings.samples
        self._fused, reason = choose(backend, why_not_fused(self.model, robot, task, self.device, dtype), self._fuse)
        if reason == NO_COMPILER and backend == "auto":
            period = period or robot.dt
        self.reset()
        if period is not None:
            self._use(samples_within(period, self.samples, self._trial))
            self.reset()

    def _fuse(self) -> FusedStep | FusedGpuStep:
        robot, sizes = replace(self.robot, mppi=self.settings), Sizes(self.samples, self.horizon)
        return fused_step(self.model, robot, self.task, device=self.device, sizes=sizes, filters=self.filters)

    @property
    def backend(self) -> str:
        """ "c" or "torch"."""
        return "torch" if self._fused is None else "c"

    def reset(self) -> None:
        """Forget the last plan and start the noise anew."""
        self._generator.manual_seed(self.seed)
        self._gone_by.reset()
        self.mean = self._rest.repeat(self.horizon, 1)  # (H, action)
        self._plan: Plan | None = None
        self._seen: tuple[Call, FilterState | None] | None = None  # of the kernel
        self.rejected = 0  # rollouts of the last step that were not finite
        self._step: int | None = None
        self._call = 0

    def remember(self, sent: ArrayLike) -> None:
        """Note what was sent on the state that was planned from last.

        Command filters, hidden states (rotors that lag) and models that see the past go on from there.
        """
        self._gone_by.remember(sent)

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` within the limits, for a state ``# (state,)`` at time ``step · dt``.

        The plan is shifted by the steps since the last call, and refined; a state that is not finite refines nothing.

        Raises:
            ShapeError: for other numbers of states or inputs, and without inputs that the model's equations use.
        """
        started = time.perf_counter()
        self._gone_by.see(state, inputs)
        gone, self._step = 0 if self._step is None else max(step - self._step, 0), step
        self._call += 1
        if self._fused is None:
            self.mean = shift(self.mean, gone)
            self.improve(state, step, self._drawn(), inputs)
        else:
            self._improve_fused(state, step, inputs, gone=gone)
        first = np.array(self.mean.tolist()[0])  # single precision may have rounded a limit away
        action: Array = np.minimum(np.maximum(first, self.robot.low), self.robot.high)
        self.missed += time.perf_counter() - started > self.period
        return action

    @property
    def draws(self) -> Draws | None:
        """The noise that the kernel draws for the action of a number, counted from 1; None where torch draws."""
        return None if self._fused is None else partial(self._fused.noise, self.seed)

    def _drawn(self) -> Tensor:
        if self._given is not None:
            return self._given(self._call).to(self.device, self.dtype)
        return sample(self.samples, self._smooth, self._spread, self._generator)

    @torch.no_grad()
    def improve(self, state: ArrayLike, step: int, noise: Tensor, inputs: ArrayLike | None = None) -> Plan:
        """One update of :attr:`mean` by noise ``# (N, H, action)``, ShapeError for other; :attr:`plan` tells of it."""
        require_steps(noise, self.mean)
        self._gone_by.see(state, inputs)
        if self._fused is not None and len(noise) == self.samples:
            self._improve_fused(state, step, inputs, noise.contiguous())
            assert self.plan is not None
            return self.plan
        actions = torch.clamp(self.mean + noise, self._low, self._high)
        past, hidden = self._gone_by.past(state), self._gone_by.hidden()
        self._plan = self._torch.plan(state, step, actions, inputs, past=past, hidden=hidden)
        self._seen = None
        self._count(self._plan.rejected, len(noise), step)
        if self.rejected < len(noise):
            self.mean = actions.permute(1, 2, 0) @ self._plan.weights
        return self._plan

    def _improve_fused(
        self, state: ArrayLike, step: int, inputs: ArrayLike | None, noise: Tensor | None = None, gone: int = 0
    ) -> None:
        """The kernel's update; the mean is shifted by the steps that have gone by."""
        assert self._fused is not None
        memory, past, hidden = self._gone_by.memory(), self._gone_by.past(state), self._gone_by.hidden()
        measured, known = single(state, self.device), self._torch.given(inputs)
        known = self._torch.nothing if known is None else known
        reference = self._torch.references.after(step)
        given = Call(measured, known, reference, self.mean, gone, self.seed, self._call, noise, memory, past, hidden)
        # Filters as they are now: a command that is remembered moves them on.
        self._seen, self._plan = (given, copy(self.filters)), None
        self.mean, self._costs, rejected = self._fused(given)
        self._count(rejected, self.samples, step)

    def _count(self, rejected: int, samples: int, step: int) -> None:
        self.rejected = rejected
        if rejected == samples:
            LOGGER.warning("MPPI: no rollout at step %d is finite, the last plan goes on", step)

    @property
    @torch.no_grad()
    def plan(self) -> Plan | None:
        """What the last step saw; None before the first one. A fused step is rolled out again to tell."""
        if self._plan is None and self._seen is not None and self._fused is not None:
            seen, filters = self._seen
            noise = self._fused.noise(seen.seed, seen.call) if seen.noise is None else seen.noise
            actions = torch.clamp(shift(seen.mean, seen.steps) + noise, self._low, self._high)
            states = self._torch.rollout(seen.state, actions, seen.inputs, filters, past=seen.past, hidden=seen.hidden)
            self._plan = Plan(states, actions, self._costs, importance_weights(self._costs, self.settings.temperature))
        return self._plan

    def _trial(self, samples: int) -> None:
        if self._fused is None:
            noise = sample(samples, self._smooth, self._spread, self._generator)
            self.improve(self.robot.start, 0, noise, self._torch.nothing)
        else:
            self._use(samples)
            self._improve_fused(self.robot.start, 0, self._torch.nothing)

    def _use(self, samples: int) -> None:
        """Draw so many samples from now on."""
        self.samples = samples
        if self._fused is not None and self._fused.samples != samples:
            self._fused = self._fuse()
