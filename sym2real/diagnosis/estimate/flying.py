"""Paths flown or driven in the plain simulator by the nominal geometric controller, with dither on its commands."""

from __future__ import annotations

import torch
from numpy.typing import ArrayLike

from sym2real.control import Disturbed, geometric_controller
from sym2real.plants import MujocoPlant, run_episode
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array, Trajectory


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
    controller = geometric_controller(robot, reference)
    dithered = Disturbed(controller, lambda step: dither[step], robot.low, robot.high)
    first = reference(torch.zeros((), dtype=torch.float64)).numpy() if start is None else start
    return run_episode(plant, dithered, start=first, steps=len(dither), name=name)
