"""One episode: a controller acts on a plant, and what happened is a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import repeat
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.errors import ShapeError
from sym2real.protocols import Controller, Plant
from sym2real.trajectory import Array, Trajectory

if TYPE_CHECKING:
    from sym2real.tasks import Task

OnStep = Callable[[int, Array, Array], None]


def run_episode(
    plant: Plant,
    controller: Controller,
    task: Task | None = None,
    *,
    seed: int = 0,
    start: ArrayLike | None = None,
    steps: int = 400,
    wrench: Array | None = None,
    on_step: OnStep | None = None,
    name: str = "",
) -> Trajectory:
    """Let a controller act for a number of steps, or until the plant crashes.

    Every row is a measured state and the action that was sent on it, as the plant says; the answer to the last action
    is not a row, so the state that a crash leaves behind is not in the trajectory. A robot's plant says by
    ``measured_at`` when it measured its state, s; a simulator's periods are even.

    Args:
        plant: what is acted on.
        controller: reset first, told after each step what was sent.
        task: gives the start state and the columns ``ref_<state column>`` in ``extra``; None for neither.
        seed: of the start state and of the plant.
        start: state to start from instead of the task's ``# (state,)``.
        steps: largest number of rows.
        wrench: by step, for plants that have ``push`` ``# (steps, inputs)``.
        on_step: called after every step with its number, the state and the action sent.
        name: of the trajectory.

    Raises:
        ShapeError: without a step, or with fewer wrenches than steps.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> task = make_task("circle", robot)
        >>> len(run_episode(MujocoPlant(robot), MPPI(compile_model(robot.nominal()), robot, task), task, steps=20))
        20
    """
    if steps < 1 or (wrench is not None and len(wrench) < steps):
        beside = "" if wrench is None else f" and {len(wrench)} wrenches"
        raise ShapeError(f"an episode needs at least one step, and a wrench for each; found {steps} steps{beside}")
    if start is None and task is not None:
        start = task.start(np.random.default_rng(seed))
    state = plant.reset(start, seed)
    controller.reset()
    wrenches = repeat(None, steps) if wrench is None else wrench[:steps]
    states, actions, inputs, stamps = _closed_loop(plant, controller, state, wrenches, on_step)
    references = {} if task is None else _references(task, plant.dt * np.arange(len(states), dtype=np.float64), plant)
    notes = ("ended by a crash",) if plant.crashed else ()
    return Trajectory(
        stamps - stamps[0], states, actions, inputs, plant.layouts, extra=references, name=name, notes=notes
    )


def _closed_loop(
    plant: Plant, controller: Controller, state: Array, wrenches: Iterable[Array | None], on_step: OnStep | None
) -> tuple[Array, Array, Array, Array]:
    """States, actions and inputs ``# (rows, …)``, one row per wrench, from the state that the reset plant measured.

    At last, when each state was measured, s ``# (rows,)``.
    """
    rows = []
    for step, given in enumerate(wrenches):
        if given is not None:
            plant.push(given)  # type: ignore[attr-defined]
        held, stamp = plant.inputs, _measured_at(plant, step)
        action = np.asarray(controller.act(state, step, held), dtype=np.float64)
        if step == 0:  # a start is held, and measured again, until the first action is there
            stamp = _measured_at(plant, step)
        measured, state = state, plant.step(action)
        sent = plant.sent
        rows.append((measured, sent, held, stamp))
        controller.remember(sent)
        if on_step is not None:
            on_step(step, measured, sent)
        if plant.crashed:
            break
    states, actions, inputs, stamps = map(np.array, zip(*rows, strict=True))
    return states, actions, inputs, stamps


def _measured_at(plant: Plant, step: int) -> float:
    return getattr(plant, "measured_at", step * plant.dt)


def _references(task: Task, time: Array, plant: Plant) -> dict[str, Array]:
    reference = task.reference(torch.as_tensor(time)).numpy()
    return {f"ref_{column}": reference[:, index] for index, column in enumerate(plant.layouts.state)}
