"""How many trajectories a base takes from nothing: random commands first, then MPPI with what was learned so far.

Equations are learned by Stage I itself, without a single scripted flight; networks by the same loop with the paper's
ensemble. After every trajectory the model is judged on the tasks of training in the plain simulator.
"""

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from torch import nn

from sym2real.adaptation import StageOne, stage_one
from sym2real.experiments.learning import training_tasks
from sym2real.experiments.study.case import Case
from sym2real.experiments.study.curves import CONVERGED, LAST
from sym2real.experiments.study.effort import Effort, OfBase
from sym2real.experiments.study.judged import judge, planning_with
from sym2real.experiments.study.neural_base import networks
from sym2real.experiments.study.outcome import Line, Outcome, Panel
from sym2real.experiments.study.sweep import Job, Record, Tell
from sym2real.plants import MujocoPlant
from sym2real.regression import BeamSearch
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task

PAPER = {
    ("crazyflie", "sr"): "10",
    ("crazyflie", "nn"): "about 160",
    ("mushr", "sr"): "under 20",
    ("mushr", "nn"): "over 100",
}
TITLES = {"sr": "SR", "nn": "NN"}
EVALUATIONS = 2  # on each of three tasks


class FromScratch(OfBase):
    """A base model from nothing, as a job of the sweep."""

    NAME = "scratch-{robot}_{model}_{seed}"

    def run(self, tell: Tell) -> Record:
        """``errors`` after every trajectory, of all evaluation episodes."""
        robot, effort = ROBOTS[self.robot], replace(self.effort, evaluations=EVALUATIONS)
        learn = _equations if self.model == "sr" else networks
        models: Iterable[Equations | nn.Module] = learn(robot, training_tasks(robot), effort, self.seed, tell)
        errors = []
        for number, model in enumerate(models, 1):
            tell(f"judging after {number} trajectories")
            make = planning_with(model, effort)
            errors.append([error for case in training_cases(robot) for error in judge(case, make, effort).errors])
        return {"errors": errors}


def training_cases(robot: Robot) -> list[Case]:
    """The tasks of training in the plain simulator."""
    return [Case(name, name, robot.name, name, options) for name, options in robot.recipe.tasks]


def _equations(robot: Robot, tasks: Sequence[Task], effort: Effort, seed: int, tell: Tell) -> list[Equations]:
    """Equations after every episode of Stage I."""
    assert effort.episodes is not None
    settings = StageOne(effort.episodes[robot.name], effort.rows, pushed=False, until_settled=False, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        engine = BeamSearch(angles=robot.recipe.angles)
        stage_one(
            MujocoPlant(robot),
            tasks,
            engine,
            settings,
            folder=Path(folder),
            on_progress=lambda progress: tell(progress.what),
        )
        files = sorted(Path(folder).glob("equations_*.json"))
        return [Equations.from_json(file.read_text(encoding="utf-8")) for file in files]


def scratch_jobs(effort: Effort) -> list[Job]:
    """Equations for both robots, and networks where the effort allows them."""
    models = ["sr", *(["nn"] if effort.neural_episodes else [])]
    return [
        FromScratch(robot, model, seed, effort) for model in models for seed in effort.seeds for robot in effort.samples
    ]


def trajectories_to_converge(errors: np.ndarray) -> int:
    """The fewest trajectories after which the error is within a tenth of the converged one.

    Args:
        errors: after every trajectory ``# (trajectories,)``; the last three are the converged one.
    """
    within = errors <= CONVERGED * errors[-LAST:].mean()
    return int(np.argmax(within)) + 1


def scratch_outcome(effort: Effort, records: Mapping[str, Record]) -> Outcome:
    """Trajectories to converge beside the paper's."""
    rows, panels = [], []
    for robot in effort.samples:
        lines = {}
        for model, title in TITLES.items():
            runs = [records.get(f"scratch-{robot}_{model}_{seed}") for seed in effort.seeds]
            errors = [np.array(run["errors"]).mean(axis=1) for run in runs if run is not None]
            if not errors:
                continue
            needed = [trajectories_to_converge(error) for error in errors]
            by_seed = np.array(errors)
            x = np.arange(1.0, by_seed.shape[1] + 1)
            lines[title] = Line(x, by_seed.mean(axis=0), by_seed.std(axis=0))
            final = f"{by_seed[:, -LAST:].mean():.4f}"
            rows.append((robot, title, ", ".join(map(str, needed)), final, PAPER[robot, model]))
        if lines:
            panels.append(Panel(ROBOTS[robot].title, lines))
    notes = [] if effort.neural_episodes else ["networks from scratch take --full: an action takes half a second"]
    columns = ("robot", "model", "trajectories to 110 %, by seed", "converged error, m", "paper")
    y = "mean position error in m"
    return Outcome("A base from scratch", columns, tuple(rows), tuple(notes), "trajectories", y, tuple(panels))
