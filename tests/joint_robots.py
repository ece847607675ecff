"""Noisy logs of simulated robots of joints, held by their regulator and dithered, with effects that nobody is told."""

from __future__ import annotations

import numpy as np

from sym2real.control import Disturbed, geometric_controller
from sym2real.effects import effect
from sym2real.experiments.excitation import ColouredNoise
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Dataset

Effects = tuple[tuple[str, dict[str, float]], ...]


def noisy_logs(robot: Robot, effects: Effects = (), *, goal: str = "", count: int = 4, rows: int = 300) -> Dataset:
    """Runs to and fro between two goals of a column, with steps of five times the usual dither."""
    logs = []
    for number in range(count):
        rng = np.random.default_rng([7, number])
        task = make_task("regulate", robot, goal={goal: 0.3 * (-1.0) ** number} if goal else None)
        dither = ColouredNoise(2.5 * np.array(robot.recipe.dither), 0.1, robot.dt, rng)
        told = Disturbed(geometric_controller(robot, task.reference), dither.of_step, robot.low, robot.high)
        changes = (sensors(robot, rng), *(effect(key, robot).inject(**values) for key, values in effects))
        logs.append(run_episode(MujocoPlant(robot, changes), told, task, seed=number, steps=rows, name=f"log_{number}"))
    return Dataset(logs)
