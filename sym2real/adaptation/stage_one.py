"""Stage I of the paper: simulate ↔ fit, one episode at a time, until tracking and prediction have settled.

The first episode is random commands; every later one is flown by MPPI with the equations found so far. Episodes
end on ground contact and are kept whatever happened in them. The wrench inputs are learned at the end, from as
many pushed episodes again (DESIGN.md, "Equations, inputs, effects").
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import torch

from sym2real.adaptation.record import Record
from sym2real.control import MPPI, RandomCommands
from sym2real.plants import MujocoPlant, random_push, run_episode
from sym2real.protocols import Controller, SymbolicRegressor
from sym2real.regression import require_dependence
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks import Task
from sym2real.trajectory import Array, Dataset, Trajectory

# Settled: the newest episode was predicted about as well as those fitted, and flown about as well as the best.
SETTLED_PREDICTION = 2.0
SETTLED_TRACKING = 1.2
FEWEST_EPISODES = 3
PUSHED_SEED = 1000


@dataclass(frozen=True)
class StageOne:
    """How the loop runs.

    Args:
        episodes: at most so many.
        steps: control steps an episode at most (paper: 400).
        samples: MPPI samples; the robot's own number by default.
        pushed: learn the wrench inputs too.
        until_settled: stop before ``episodes`` when nothing gets better.
        seed: of starts, commands, pushes and samples.
    """

    episodes: int = 10
    steps: int = 400
    samples: int | None = None
    pushed: bool = True
    until_settled: bool = True
    seed: int = 0


@dataclass(frozen=True)
class EpisodeReport:
    """One episode of the loop.

    Args:
        number: counted from 0.
        task: name of the task, "random commands" for the first.
        rows: length.
        crashed: it ended on the ground.
        tracking: mean position error in m, NaN for random commands.
        prediction: one-step error of the equations that flew it, relative to how far states move in a step
            (root mean square over state columns); NaN for the first.
        fitted: the same of the equations fitted afterwards, on all rows so far.
        seconds: time of the fit.
    """

    number: int
    task: str
    rows: int
    crashed: bool
    tracking: float
    prediction: float
    fitted: float
    seconds: float


@dataclass(frozen=True)
class Progress:
    """What is going on: ``done`` of ``total`` steps of ``what``; an episode's report when it is complete."""

    what: str
    done: int
    total: int
    report: EpisodeReport | None = None


@dataclass(frozen=True)
class BaseModel:
    """What Stage I found, and from what.

    Args:
        equations: the base model.
        episodes: the paper's trajectories, unpushed.
        pushed: the further trajectories that taught the wrench inputs.
        reports: one per unpushed episode.
    """

    equations: Equations
    episodes: tuple[Trajectory, ...]
    pushed: tuple[Trajectory, ...]
    reports: tuple[EpisodeReport, ...]


def _silent(_: Progress) -> None:
    pass


def learn_base(
    plant: MujocoPlant,
    tasks: Sequence[Task],
    engine: SymbolicRegressor[Equations],
    settings: StageOne | None = None,
    *,
    folder: Path | None = None,
    on_progress: Callable[[Progress], None] = _silent,
) -> Equations:
    """The equations of :func:`stage_one`, for those who want nothing else."""
    return stage_one(plant, tasks, engine, settings, folder=folder, on_progress=on_progress).equations


def stage_one(
    plant: MujocoPlant,
    tasks: Sequence[Task],
    engine: SymbolicRegressor[Equations],
    settings: StageOne | None = None,
    *,
    folder: Path | None = None,
    on_progress: Callable[[Progress], None] = _silent,
) -> BaseModel:
    """Learn a base model in a plain simulator.

    Args:
        plant: the simulator.
        tasks: flown in turn, from the second episode on.
        engine: finds the equations.
        settings: of the loop.
        folder: keeps every episode and fit as it happens; a second call continues there.
        on_progress: told of every control step and every finished episode.

    Raises:
        ModelError: when the equations miss a dependence that control needs, or the folder holds another run.
    """
    loop = _Loop(plant, tuple(tasks), engine, settings or StageOne(), Record(folder, plant.layouts), on_progress)
    loop.record.claim(
        {"robot": plant.robot.name, "tasks": [task.name for task in tasks], "engine": repr(engine)}
        | {key: value for key, value in asdict(loop.settings).items() if key not in ("episodes", "until_settled")}
    )
    return loop.run()


@dataclass(frozen=True)
class _Loop:
    plant: MujocoPlant
    tasks: tuple[Task, ...]
    engine: SymbolicRegressor[Equations]
    settings: StageOne
    record: Record
    on_progress: Callable[[Progress], None]

    def run(self) -> BaseModel:
        episodes: list[Trajectory] = []
        reports: list[EpisodeReport] = []
        equations: Equations | None = None
        for number in range(self.settings.episodes):
            flown_by = equations
            episodes.append(self._episode(number, flown_by))
            started = time.perf_counter()
            equations = self._fit(f"equations_{number:03d}", episodes, flown_by)
            reports.append(self._report(number, episodes, flown_by, equations, time.perf_counter() - started))
            self.on_progress(Progress("episodes", number + 1, self.settings.episodes, reports[-1]))
            if self.settings.until_settled and settled(reports):
                break
        if equations is None:
            raise ValueError("Stage I needs at least one episode")
        pushed: list[Trajectory] = []
        if self.settings.pushed:
            pushed = [self._pushed(number, equations) for number in range(len(episodes))]
            equations = self._fit("equations_pushed", [*episodes, *pushed], equations)
        return BaseModel(equations, tuple(episodes), tuple(pushed), tuple(reports))

    def _fit(self, name: str, episodes: Sequence[Trajectory], start: Equations | None) -> Equations:
        self.on_progress(Progress(f"fitting {len(episodes)} episodes", 0, 0))
        transitions = Dataset(episodes).transitions()
        equations = self.record.equations(name, lambda: self.engine.fit(transitions, start))
        require_dependence(equations, transitions, self.plant.robot.dependencies)
        return equations

    def _task(self, number: int) -> Task | None:
        return self.tasks[(number - 1) % len(self.tasks)] if number else None

    def _controller(self, number: int, equations: Equations | None) -> Controller:
        task, seed = self._task(number), self.settings.seed + number
        if task is None or equations is None:
            return RandomCommands(self.plant.robot, seed=seed)
        sampling = self.plant.robot.mppi
        if self.settings.samples is not None:
            sampling = replace(sampling, samples=self.settings.samples)
        return MPPI(compile_model(equations), self.plant.robot, task, settings=sampling, seed=seed)

    def _episode(self, number: int, equations: Equations | None) -> Trajectory:
        return self._fly(f"episode_{number:03d}", number, equations, self.settings.seed + number, None)

    def _pushed(self, number: int, equations: Equations) -> Trajectory:
        seed = self.settings.seed + PUSHED_SEED + number
        wrench = random_push(self.plant.robot, self.settings.steps, np.random.default_rng(seed))
        return self._fly(f"pushed_{number:03d}", number, equations, seed, wrench)

    def _fly(self, name: str, number: int, equations: Equations | None, seed: int, wrench: Array | None) -> Trajectory:
        task, steps = self._task(number), self.settings.steps
        what = f"{name.replace('_', ' ')}: {task.name if task else 'random commands'}"
        return self.record.episode(
            name,
            lambda: run_episode(
                self.plant,
                self._controller(number, equations),
                task or self.tasks[0],
                seed=seed,
                steps=steps,
                wrench=wrench,
                on_step=lambda step, *_: self.on_progress(Progress(what, step + 1, steps)),
                name=name,
            ),
        )

    def _report(
        self,
        number: int,
        episodes: Sequence[Trajectory],
        flown_by: Equations | None,
        equations: Equations,
        seconds: float,
    ) -> EpisodeReport:
        task, newest = self._task(number), episodes[-1]
        return EpisodeReport(
            number=number,
            task=task.name if task else "random commands",
            rows=len(newest),
            crashed=len(newest) < self.settings.steps,
            tracking=tracking_error(newest) if task else float("nan"),
            prediction=one_step_error(flown_by, Dataset([newest])) if flown_by else float("nan"),
            fitted=one_step_error(equations, Dataset(episodes)),
            seconds=seconds,
        )


def tracking_error(trajectory: Trajectory) -> float:
    """Mean distance in m from the reference, the paper's performance metric."""
    columns = trajectory.layouts.state.field("position").columns
    offsets = [trajectory.column(column) - trajectory.extra[f"ref_{column}"] for column in columns]
    return float(np.sqrt(np.square(offsets).sum(axis=0)).mean())


def one_step_error(equations: Equations, data: Dataset) -> float:
    """One-step prediction error relative to how far states move, root mean square over state columns."""
    transitions = data.transitions()
    model = compile_model(equations, dtype=torch.float64)
    with torch.no_grad():
        predicted = model(
            torch.as_tensor(transitions.state),
            torch.as_tensor(transitions.action),
            torch.as_tensor(transitions.inputs),
        ).numpy()
    error = ((predicted - transitions.next_state) ** 2).mean(axis=0)
    moved = ((transitions.next_state - transitions.state) ** 2).mean(axis=0)
    return float(np.sqrt(np.mean(error[moved > 0] / moved[moved > 0])))


def settled(reports: Sequence[EpisodeReport]) -> bool:
    """True when the newest episode was predicted like the fitted ones and flown like the best of its task."""
    newest = reports[-1]
    if len(reports) < FEWEST_EPISODES or newest.crashed:
        return False
    earlier = [report.tracking for report in reports[:-1] if report.task == newest.task and not report.crashed]
    return (
        bool(earlier)
        and newest.prediction < SETTLED_PREDICTION * newest.fitted
        and newest.tracking < SETTLED_TRACKING * min(earlier)
    )
