"""A base that has seen one goal, or a narrow range of starts, where it has never been (the paper's zero-shot table)."""

from collections.abc import Mapping

import numpy as np
from torch import nn

from sym2real.adaptation import StageOne, learn_base
from sym2real.control import mppi_controller
from sym2real.experiments.flying import fly
from sym2real.experiments.study.effort import Effort, OfBase
from sym2real.experiments.study.neural_base import networks
from sym2real.experiments.study.outcome import Outcome
from sym2real.experiments.study.scratch import TITLES
from sym2real.experiments.study.sweep import Job, Record, Tell
from sym2real.plants import MujocoPlant
from sym2real.regression import BeamSearch
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task, make_task, unseen_goal
from sym2real.tasks.task import flies

RUNS, REACHED = 20, 0.2  # m in the mean over the last second
TRAINING = {"crazyflie": ("hover", 10), "mushr": ("park", 20)}  # task and episodes
TEST_SEED = 9001
# Percent in distribution and out of it.
PAPER = {
    ("mushr", "sr"): (100, 90),
    ("mushr", "nn"): (100, 20),
    ("crazyflie", "sr"): (100, 100),
    ("crazyflie", "nn"): (100, 30),
}


class ZeroShot(OfBase):
    """One row of the table, as a job of the sweep."""

    NAME = "zero-shot-{robot}_{model}"

    def run(self, tell: Tell) -> Record:
        """Percent of the runs that reached their goal, in distribution (``seen``) and out of it (``unseen``)."""
        model, answer = self._learned(tell), {}
        for where in ("seen", "unseen"):
            successes = 0
            for run in range(RUNS):
                tell(f"{where} start {run + 1} of {RUNS}")
                successes += self._reaches(model, run, unseen=where == "unseen")
            answer[where] = 100 * successes / RUNS
        return answer

    def _learned(self, tell: Tell) -> Equations | nn.Module:
        """The base, from one goal or a narrow range of starts."""
        robot, seed = ROBOTS[self.robot], self.seed
        task, episodes = TRAINING[self.robot]
        tasks = [make_task(task, robot)]
        if self.model == "nn":
            return list(networks(robot, tasks, self.effort, seed, tell))[-1]
        settings = StageOne(episodes, self.effort.rows, pushed=False, until_settled=False, seed=seed)
        engine = BeamSearch(angles=robot.recipe.angles)
        return learn_base(MujocoPlant(robot), tasks, engine, settings, on_progress=lambda progress: tell(progress.what))

    def _reaches(self, model: Equations | nn.Module, run: int, *, unseen: bool) -> bool:
        robot = ROBOTS[self.robot]
        task = task_of(robot, run, unseen=unseen)
        controller = mppi_controller(model, robot, task, samples=self.effort.samples[self.robot], seed=run)
        flight = fly(MujocoPlant(robot), controller, task, seed=TEST_SEED + run)
        return not flight.crashed and flight.final < REACHED


def task_of(robot: Robot, run: int, *, unseen: bool) -> Task:
    """The task of a run, in distribution or out of it; a car's start goes with the episode's seed."""
    if not flies(robot):
        return make_task("park", robot, start_region="unseen" if unseen else "seen")
    goal = {"goal": tuple(unseen_goal(np.random.default_rng([TEST_SEED, run])))} if unseen else {}
    return make_task("hover", robot, **goal)


def zero_shot_jobs(effort: Effort) -> list[Job]:
    """Equations for both robots, and networks where the effort allows them."""
    models = ["sr", *(["nn"] if effort.neural_episodes else [])]
    return [ZeroShot(robot, model, effort.seeds[0], effort) for model in models for robot in effort.samples]


def zero_shot_outcome(effort: Effort, records: Mapping[str, Record]) -> Outcome:
    """The paper's table, with its figures beside."""
    rows = []
    for robot in effort.samples:
        for model, title in TITLES.items():
            record = records.get(f"zero-shot-{robot}_{model}")
            if record is not None:
                seen, unseen = PAPER[robot, model]
                errors = [f"{record[where]:.0f}" for where in ("seen", "unseen")]
                rows.append((robot, title, *errors, f"{seen}, {unseen}"))
    notes = [f"{RUNS} runs a cell: a difference of less than about 20 % is chance"]
    notes += [] if effort.neural_episodes else ["networks take --full"]
    columns = ("robot", "model", "in distribution, %", "out of it, %", "paper, %")
    return Outcome("Zero-shot from where training never was", columns, tuple(rows), tuple(notes))
