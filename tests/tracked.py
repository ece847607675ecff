"""Simulated episodes in which a controller that knows every state follows a task, for tests that learn from them."""

from __future__ import annotations

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset, Transitions
from sym2real.plants import EquationsPlant, MujocoPlant, run_episode
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory


def episode(
    plant: MujocoPlant | EquationsPlant, task: str = "circle", *, steps: int = 200, seed: int = 0, name: str = ""
) -> Trajectory:
    wanted = make_task(task, plant.robot)
    controller = geometric_controller(plant.robot, wanted.reference)
    return run_episode(plant, controller, wanted, seed=seed, steps=steps, name=name)


def tracked(
    plant: MujocoPlant | EquationsPlant, task: str = "circle", *, rows: int = 200, seed: int = 0
) -> Transitions:
    return Dataset([episode(plant, task, steps=rows + 1, seed=seed)]).transitions()
