"""One task, one controller, one plant: flown or driven, timed and summed up."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sym2real.adaptation import tracking_error
from sym2real.plants import run_episode
from sym2real.protocols import Controller, Plant
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
