"""How good a model is in a target: episodes whose starts, noise and samples are the same for every model.

What a perfect model would reach, the reference, is MPPI whose model is the target's MuJoCo itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from torch import Tensor, nn

from sym2real.adaptation import episode_cost, episode_error
from sym2real.control import MPPI, mppi_controller
from sym2real.experiments.study.case import Case
from sym2real.experiments.study.effort import Effort, OfStudy
from sym2real.experiments.study.sweep import Record, Tell
from sym2real.plants import MujocoPlant, rollout_mujoco, run_episode
from sym2real.protocols import Controller
from sym2real.robots import Robot
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks import Task

Make = Callable[[MujocoPlant, Robot, Task, int], Controller]
# Episodes that judge have seeds beyond those of any run that learns.
FIRST_SEED = 9001
REFERENCE = "mujoco"


class Judged(NamedTuple):
    """Episodes of one model."""

    errors: list[float]  # mean position error of each in m; rows that a crash has cost count as the workspace's radius
    costs: list[float]  # mean running cost of each
    crashes: int  # how many ended early


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
        [episode_error(episode, robot, effort.rows) for episode in episodes],
        [episode_cost(episode, task, robot, effort.rows) for episode in episodes],
        sum(len(episode) < effort.rows for episode in episodes),
    )


def planning_with(model: Equations | nn.Module, effort: Effort) -> Make:
    """MPPI with a model."""
    return lambda _, robot, task, seed: mppi_controller(
        model, robot, task, samples=effort.samples[robot.name], seed=seed
    )


@dataclass(frozen=True)
class Reference(OfStudy):
    """The evaluation episodes of a case with the reference controller, as a job of the sweep.

    Args:
        case: target and task; without command filters and forces that depend on the state.
        effort: of the study.
    """

    NAME = f"{{case.name}}_{REFERENCE}"

    case: Case
    effort: Effort

    @staticmethod
    def name_of(case: Case) -> str:
        """The reference's name on a case."""
        return Reference.NAME.format(case=case)

    def run(self, tell: Tell) -> Record:
        """Errors, costs and crashes of the episodes."""
        return judge(self.case, planning_with_mujoco(self.effort), self.effort, tell)._asdict()


def has_reference(case: Case) -> bool:
    """Whether MuJoCo's rollouts can do all that the target does: command filters are outside of them."""
    return not any(change.command for change in case.plant(0).changes)


def planning_with_mujoco(effort: Effort) -> Make:
    """MPPI with the target itself as the model, on the same cost, samples and noise as with equations."""

    def make(plant: MujocoPlant, robot: Robot, task: Task, seed: int) -> Controller:
        settings = replace(robot.mppi, samples=effort.samples[robot.name])
        draws = MPPI(compile_model(robot.nominal()), robot, task, settings=settings, seed=seed).draws
        return MPPI(MujocoModel(plant), robot, task, settings=settings, seed=seed, draws=draws)

    return make


class MujocoModel:
    """Rolls actions out from the plant's present physics state, not from the measured state that it is given.

    Forces that act now are held over the horizon: exact for a steady wind. Physics steps are the plant's own, or fewer
    where that changes nothing.

    Args:
        plant: the plant that the controller flies; it must have no command filters.
    """

    def __init__(self, plant: MujocoPlant) -> None:
        self.plant, self.substeps = plant, plant.robot.description.coarse_substeps or None
        self._has_forces = plant.inputs.any() or any(change.force for change in plant.changes)

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """State ``# (N, state)`` after one action ``# (N, action)``."""
        return self.rollout(state, action[:, None], inputs)[:, 0]

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (N, H, state)`` after each action ``# (N, H, action)``."""
        commands, start = actions.double().cpu().numpy(), self.plant.full_state
        forces = self.plant.forces if self._has_forces else None
        states = rollout_mujoco(self.plant, start, commands, forces=forces, substeps=self.substeps)
        return torch.as_tensor(states).to(actions)
