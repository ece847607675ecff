"""One task, one controller, one plant: flown or driven, timed and summed up."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.adaptation import tracking_error
from sym2real.control import MPPI
from sym2real.effects.filters import FilterState, command_filters, measurement_filters
from sym2real.effects.sensors import Sensors
from sym2real.effects.visible import VisibleModel
from sym2real.errors import ModelError
from sym2real.plants import run_episode
from sym2real.protocols import Controller, Plant
from sym2real.robots import Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task
from sym2real.trajectory import Array, Trajectory

OnStep = Callable[[int], None]


@dataclass(frozen=True)
class Flight:
    """An episode and what a person asks about it.

    Args:
        trajectory: what happened.
        tracking: mean distance from the reference in m.
        final: the same over the last second.
        crashed: it ended early.
        act_median, act_p99: time to choose an action in s.
    """

    trajectory: Trajectory
    tracking: float
    final: float
    crashed: bool
    act_median: float
    act_p99: float


def mppi_controller(
    equations: Equations,
    robot: Robot,
    task: Task,
    *,
    samples: int | None = None,
    seed: int = 0,
    period: float | None = None,
) -> MPPI | CorrectedMPPI:
    """MPPI with these equations and the robot's sampling, with another number of samples where one is given.

    Where the equations hold measurement effects, MPPI receives the state without them, so that references keep their
    meaning; where their inputs are others than the robot's (a time, or none at all), those that they have.

    Raises:
        ModelError: for equations whose measurements have memory, which cannot be undone.
    """
    late = [one.key for one, _ in measurement_filters(equations)]
    if late:
        raise ModelError(f"{', '.join(late)} cannot be undone step by step: control needs the present state")
    settings = robot.mppi if samples is None else replace(robot.mppi, samples=samples)
    filters = FilterState(equations) if command_filters(equations) else None
    mppi = MPPI(VisibleModel(equations), robot, task, settings=settings, seed=seed, filters=filters, period=period)
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
        """Of the controller, which draws fewer once it has missed its period."""
        return self._controller.samples

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)`` and the robot's inputs ``# (inputs,)``."""
        measured = torch.as_tensor(np.asarray(state, dtype=np.float64))
        return self._controller.act(self._sensors.state(measured).numpy(), step, self._known(step, inputs))

    def _known(self, step: int, inputs: ArrayLike | None) -> ArrayLike | None:
        """By name; what neither the robot nor the clock gives is left to the controller to miss."""
        held = np.zeros(len(self._given)) if inputs is None else np.asarray(inputs, dtype=np.float64)
        known = {**dict(zip(self._given, held, strict=False)), "t": step * self._controller.robot.dt}
        return np.array([known[name] for name in self._wanted]) if known.keys() >= set(self._wanted) else inputs


def fly(
    plant: Plant,
    controller: Controller,
    task: Task,
    *,
    seconds: float | None = None,
    seed: int = 0,
    on_step: OnStep = lambda _: None,
    name: str = "",
) -> Flight:
    """Run one episode and sum it up.

    Args:
        plant: what is flown or driven.
        controller: what flies or drives it.
        task: what is wanted.
        seconds: length; the task's own by default.
        seed: of the start.
        on_step: called with the number of steps done.
        name: of the trajectory.

    Raises:
        ShapeError: where that is no step.
    """
    steps = round((task.duration if seconds is None else seconds) / plant.dt)
    timed = _Timed(controller)
    trajectory = run_episode(
        plant, timed, task, seed=seed, steps=steps, on_step=lambda step, *_: on_step(step + 1), name=name
    )
    return Flight(
        trajectory=trajectory,
        tracking=tracking_error(trajectory),
        final=tracking_error(trajectory.rows(max(0, len(trajectory) - round(1.0 / plant.dt)), len(trajectory))),
        crashed=len(trajectory) < steps,
        act_median=float(np.median(timed.seconds)),
        act_p99=float(np.quantile(timed.seconds, 0.99)),
    )


class _Timed:
    """A controller that notes how long it takes to choose an action."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.seconds: list[float] = []

    def reset(self) -> None:
        self.controller.reset()

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        started = time.perf_counter()
        action = self.controller.act(state, step, inputs)
        self.seconds.append(time.perf_counter() - started)
        return action

    def remember(self, sent: ArrayLike) -> None:
        self.controller.remember(sent)
