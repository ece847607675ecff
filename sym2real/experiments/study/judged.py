"""How good a model is in a target: episodes whose starts, noise and samples are the same for every model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from torch import nn

from sym2real.adaptation import episode_cost, episode_error
from sym2real.control import mppi_controller
from sym2real.experiments.study.case import Case
from sym2real.experiments.study.effort import Effort
from sym2real.plants import MujocoPlant, run_episode
from sym2real.protocols import Controller
from sym2real.robots import Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task

Make = Callable[[MujocoPlant, Robot, Task, int], Controller]
# Episodes that judge have seeds beyond those of any run that learns.
FIRST_SEED = 9001


@dataclass(frozen=True)
class Judged:
    """Episodes of one model.

    Args:
        errors: mean position error of each in m; rows that a crash has cost count as the workspace's radius.
        costs: mean running cost of each.
        crashes: how many ended early.
    """

    errors: tuple[float, ...]
    costs: tuple[float, ...]
    crashes: int

    def to_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {"errors": list(self.errors), "costs": list(self.costs), "crashes": self.crashes}


def judge(case: Case, make: Make, effort: Effort, tell: Callable[[str], None] = lambda _: None) -> Judged:
    """Fly the evaluation episodes of a case.

    Args:
        case: target and task.
        make: gives the controller for a target, a robot, a task and a seed.
        effort: how many episodes, and how long.
        tell: takes a line before every episode.
    """
    robot, task = case.of_robot, case.of_task()
    episodes = []
    for seed in range(FIRST_SEED, FIRST_SEED + effort.evaluations):
        tell(f"evaluation episode {seed - FIRST_SEED + 1} of {effort.evaluations}")
        plant = case.plant(seed)
        controller = make(plant, robot, task, seed)
        episodes.append(run_episode(plant, controller, task, seed=seed, steps=effort.rows))
    return Judged(
        tuple(episode_error(episode, robot, effort.rows) for episode in episodes),
        tuple(episode_cost(episode, task, robot, effort.rows) for episode in episodes),
        sum(len(episode) < effort.rows for episode in episodes),
    )


def planning_with(model: Equations | nn.Module, effort: Effort) -> Make:
    """MPPI with a model."""
    return lambda _, robot, task, seed: mppi_controller(
        model, robot, task, samples=effort.samples[robot.name], seed=seed
    )
