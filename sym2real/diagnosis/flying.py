"""Paths flown or driven in the plain simulator by the nominal geometric controller, with dither on its commands."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.control import GeometricQuadrotor, PurePursuit
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Controller
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array, Trajectory


class _Dithered:
    """A controller with something on top of its commands, row by row."""

    def __init__(self, controller: Controller, dither: Array, low: Array, high: Array) -> None:
        self.controller, self.dither, self.low, self.high = controller, dither, low, high

    def reset(self) -> None:
        self.controller.reset()

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        wanted = self.controller.act(state, step, inputs) + self.dither[step]
        action: Array = np.clip(wanted, self.low, self.high)
        return action

    def remember(self, sent: ArrayLike) -> None:
        self.controller.remember(sent)


def fly(
    plant: MujocoPlant, reference: Reference, dither: Array, *, start: ArrayLike | None = None, name: str = ""
) -> Trajectory:
    """A path in the simulator, until its end or a crash.

    Args:
        plant: the plain simulator.
        reference: states of the path at times in s ``# (..., state)``.
        dither: on the commands, by row ``# (rows, action)``.
        start: first state; that of the path by default ``# (state,)``.
        name: of the trajectory.
    """
    robot = plant.robot
    controller: Controller
    if robot.layouts.state.has_field("attitude"):
        controller = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference)
    else:
        controller = PurePursuit(robot.constants["wheelbase"], robot.low, robot.high, robot.dt, reference)
    dithered = _Dithered(controller, dither, robot.low, robot.high)
    first = reference(torch.zeros((), dtype=torch.float64)).numpy() if start is None else start
    return run_episode(plant, dithered, start=first, steps=len(dither), name=name)
