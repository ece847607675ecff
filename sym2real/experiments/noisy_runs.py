"""Noisy runs of any robot in its simulator: its controller, dither on the commands, noise on what is measured.

A noisy plant has the noise of an episode's seed: the same seed flies the same way.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.effects import effect
from sym2real.experiments.excitation import dithered
from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Plant
from sym2real.robots import Robot
from sym2real.tasks.task import Task
from sym2real.trajectory import Array

Effects = Sequence[tuple[str, Mapping[str, float]]]


def noisy_runs(
    robot: Robot,
    tasks: Sequence[Task],
    effects: Effects = (),
    *,
    count: int = 8,
    rows: int = 400,
    dither: float = 2.0,
    seed: int = 0,
    plant: Callable[[np.random.Generator], Plant] | None = None,
) -> Dataset:
    """Logs of a robot with effects that nothing in them names.

    Args:
        robot: what runs.
        tasks: gone through again and again.
        effects: key and values of each that the plant has.
        count: of runs.
        rows: of a run; fewer where it ends in a crash.
        dither: factor on the usual one of the robot.
        seed: of noise and dither.
        plant: in place of the robot's simulator with these effects, by the generator of its sensors' noise.
    """
    runs, changes = [], tuple(effect(key, robot).inject(**values) for key, values in effects)
    for number in range(count):
        rng, task = np.random.default_rng([seed, number]), tasks[number % len(tasks)]
        sent = dithered(geometric_controller(robot, task.reference), robot, rng, dither)
        target = plant(rng) if plant else MujocoPlant(robot, (sensors(robot, rng), *changes))
        runs.append(run_episode(target, sent, task, seed=number, steps=rows, name=f"run_{number + 1}"))
    return Dataset(runs)


class NoisyPlant(MujocoPlant):
    """Position 0.5 mm, attitude 0.3°, rates 0.02 rad/s, velocity by differences.

    Args:
        plant: without noise. Its own sensor effects act on what is measured.
    """

    def __init__(self, plant: MujocoPlant) -> None:
        self._rng = np.random.default_rng(0)
        changes = (sensors(plant.robot, self._rng), *plant.changes)
        super().__init__(plant.robot, changes, description=plant.description)

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode with the noise of this seed; the measured state ``# (state,)``."""
        self._rng.bit_generator.state = np.random.default_rng(seed or 0).bit_generator.state
        return super().reset(state)
