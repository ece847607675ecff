"""Neural bases: an ensemble from flights in the plain simulator, and one from scratch, trajectory by trajectory."""

from collections.abc import Iterator, Sequence

import numpy as np
from filelock import FileLock
from torch import nn

from sym2real.control import RandomCommands, mppi_controller
from sym2real.dataset import Dataset
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.experiments.models import base_folder
from sym2real.experiments.study.effort import Effort
from sym2real.experiments.study.sweep import Tell
from sym2real.files import make_folder
from sym2real.neural import Ensemble, EnsembleTraining, open_model, save_model
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Controller
from sym2real.robots import Robot
from sym2real.symbolic.storage import INVENTORY
from sym2real.tasks import Task
from sym2real.tasks.task import flies
from sym2real.trajectory import Trajectory

SEED = 1


def training(robot: Robot, effort: Effort, seed: int) -> EnsembleTraining:
    """How an ensemble of this effort is trained."""
    return EnsembleTraining(members=effort.members, widths=effort.widths, robot=robot.name, seed=seed)


def cached_ensemble(robot: Robot, effort: Effort) -> Ensemble:
    """An ensemble from scripted flights in the plain simulator, learned at the first call and kept in the user's cache.

    It sees more than the equations do: on as few trajectories it could not fly at all.
    """
    shape = "-".join(map(str, effort.widths))
    folder = make_folder(base_folder(robot).parent)
    model = folder / f"ensemble-{robot.name}-{effort.neural_flights}-{effort.members}x{shape}"
    with FileLock(f"{model}.lock"):
        if not (model / INVENTORY).exists():  # it takes its place last
            flights = (quadrotor_flights if flies(robot) else car_drives)(effort.neural_flights, SEED)
            save_model(training(robot, effort, SEED).fit(flights.transitions()), model)
        opened = open_model(model)
    assert isinstance(opened, Ensemble)
    return opened


def networks(robot: Robot, tasks: Sequence[Task], effort: Effort, seed: int, tell: Tell) -> Iterator[nn.Module]:
    """An ensemble after every trajectory of the loop that Stage I is for equations."""
    assert effort.neural_episodes is not None
    plant, learner, flown = MujocoPlant(robot), training(robot, effort, seed), list[Trajectory]()
    model = None
    for number in range(effort.neural_episodes[robot.name]):
        tell(f"trajectory {number + 1} of {effort.neural_episodes[robot.name]}")
        task, rng = tasks[(number - 1) % len(tasks)], np.random.default_rng([seed, number])
        flown += _episodes(plant, task, model, effort, rng)
        model = learner.fit(Dataset(flown).transitions(), None, model)
        yield model


def _episodes(
    plant: MujocoPlant, task: Task, model: nn.Module | None, effort: Effort, rng: np.random.Generator
) -> Iterator[Trajectory]:
    """One episode; of random commands as many as fill it, since a quadrotor is soon on the ground."""
    robot, left = plant.robot, effort.rows
    while left > 1:
        seed = int(rng.integers(2**31))
        controller: Controller = RandomCommands(robot, seed=seed)
        if model is not None:
            controller = mppi_controller(model, robot, task, samples=effort.samples[robot.name], seed=seed)
        episode = run_episode(plant, controller, task, seed=seed, steps=left)
        left -= len(episode) if model is None else left
        yield episode
