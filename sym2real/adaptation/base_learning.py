"""Stage I of the paper: simulate ↔ fit, one episode at a time, until tracking and prediction have settled.

The first episode is random commands; every later one is flown by MPPI with the equations found so far. Ground contact
ends a trajectory, and everything is kept whatever happened in it. A quadrotor under random commands is on the ground
after half a second, so the first episode is put back to its start until its steps are used up; later ones are not.
The wrench inputs are learned at the end, from as many episodes again with known
disturbances (docs/architecture.md, "An episode of Stage I").
"""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from sym2real.adaptation.episode_report import EpisodeReport, settled, tracking_error
from sym2real.adaptation.predictions import one_step_error
from sym2real.adaptation.progress import OnProgress, Progress, silent
from sym2real.adaptation.record import Record
from sym2real.control import RandomCommands, mppi_controller
from sym2real.dataset import Dataset
from sym2real.errors import ModelError
from sym2real.layout import unit_of_place
from sym2real.plants import MujocoPlant, random_wrench, run_episode
from sym2real.protocols import Controller, SymbolicRegressor
from sym2real.regression import require_dependence
from sym2real.symbolic import Equations
from sym2real.tasks import Task
from sym2real.tasks.task import digest_of_reference
from sym2real.trajectory import Trajectory

KINDS = ("episode", "pushed")
RANDOM_COMMANDS = "random commands"
# A try shorter than this holds one command at most.
SHORTEST_TRY = 10


@dataclass(frozen=True)
class StageOne:
    """How the loop runs.

    Args:
        episodes: at most so many.
        steps: control steps an episode at most (paper: 400).
        samples: MPPI samples; the robot's own number by default.
        pushed: learn the wrench inputs too.
        until_settled: stop before ``episodes`` when nothing gets better.
        seed: of starts, commands, wrenches and samples.

    Raises:
        ModelError: without an episode, or with one too short to learn from.

    Examples:
        >>> StageOne(episodes=2, steps=100, pushed=False).until_settled
        True
    """

    episodes: int = 10
    steps: int = 400
    samples: int | None = None
    pushed: bool = True
    until_settled: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        if self.episodes < 1 or self.steps < SHORTEST_TRY:
            raise ModelError(
                f"Stage I needs at least one episode of {SHORTEST_TRY} steps, found {self.episodes} of {self.steps}"
            )


@dataclass(frozen=True)
class BaseModel:
    """What Stage I found, and from what.

    Args:
        equations: the base model.
        episodes: the paper's trajectories, without a wrench.
        pushed: the further trajectories that taught the wrench inputs.
        reports: one per episode without a wrench.
    """

    equations: Equations
    episodes: tuple[Trajectory, ...]
    pushed: tuple[Trajectory, ...]
    reports: tuple[EpisodeReport, ...]


def learn_base(
    plant: MujocoPlant,
    tasks: Sequence[Task],
    engine: SymbolicRegressor[Equations],
    settings: StageOne | None = None,
    *,
    folder: Path | None = None,
    on_progress: OnProgress = silent,
) -> Equations:
    """The equations of :func:`stage_one`, for those who want nothing else.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> tasks, engine = [make_task("circle", robot)], BeamSearch(angles=robot.recipe.angles)
        >>> base = learn_base(MujocoPlant(robot), tasks, engine, StageOne(episodes=1, steps=100, pushed=False))
        >>> base.depends("wz", "steer")
        True
    """
    return stage_one(plant, tasks, engine, settings, folder=folder, on_progress=on_progress).equations


def stage_one(
    plant: MujocoPlant,
    tasks: Sequence[Task],
    engine: SymbolicRegressor[Equations],
    settings: StageOne | None = None,
    *,
    folder: Path | None = None,
    on_progress: OnProgress = silent,
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
        ModelError: without a task, when the equations miss a dependence that control needs, or when the folder holds
            another run.
        DataError: when what the folder holds cannot be read, or nothing can be written there.
    """
    if not tasks:
        raise ModelError("Stage I needs at least one task")
    loop = _Loop(plant, tuple(tasks), engine, settings or StageOne(), Record(folder, plant.layouts), on_progress)
    loop.record.claim(
        {
            "robot": plant.robot.name,
            "tasks": [task.name for task in tasks],
            "references": [digest_of_reference(task) for task in tasks],
            "engine": repr(engine),
        }
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
    on_progress: OnProgress

    def run(self) -> BaseModel:
        """Episodes and fits in turn, the episodes under a wrench, the last fit; errors as of :func:`stage_one`."""
        episodes: list[Trajectory] = []
        reports: list[EpisodeReport] = []
        equations: Equations | None = None
        for number in range(self.settings.episodes):
            flown_by = equations
            newest = self._episode("episode", number, flown_by)
            episodes += newest
            started = time.perf_counter()
            equations = self._fit(f"equations_{number:03d}", episodes, flown_by)
            seconds = time.perf_counter() - started
            reports.append(self._report(number, newest, flown_by, seconds, one_step_error(equations, episodes)))
            self.on_progress(Progress("episodes", number + 1, self.settings.episodes, reports[-1]))
            if self.settings.until_settled and settled(reports):
                break
        assert equations is not None  # there is an episode at least
        under_wrench: list[Trajectory] = []
        behind = f"_behind_{len(reports):03d}"  # a run that goes on with more episodes flies and fits these anew
        if self.settings.pushed:
            for number in range(len(reports)):
                under_wrench += self._episode("pushed", number, equations, behind)
        # A warm start keeps terms that were chosen from fewer rows; the last fit chooses among all of them anew.
        equations = self._fit(f"base{behind}", [*episodes, *under_wrench], None)
        require_dependence(equations, Dataset(episodes).transitions(), self.plant.robot.recipe.dependencies)
        return BaseModel(equations, tuple(episodes), tuple(under_wrench), tuple(reports))

    def _fit(self, name: str, episodes: Sequence[Trajectory], start: Equations | None) -> Equations:
        self.on_progress(Progress(f"fitting {len(episodes)} trajectories", 0, 0))
        fit, signed = self.engine.fit, self.plant.robot.signed
        return self.record.equations(name, lambda: signed(fit(Dataset(episodes).transitions(), start)))

    def _episode(self, kind: str, number: int, equations: Equations | None, behind: str = "") -> list[Trajectory]:
        """One trajectory or, of random commands, as many as fill the episode."""
        if number > 0:
            return [self._fly(f"{kind}_{number:03d}{behind}", kind, number, equations, self.settings.steps)]
        tries: list[Trajectory] = []
        left = self.settings.steps
        while left >= SHORTEST_TRY:
            tries.append(self._fly(f"{kind}_000_{len(tries):02d}", kind, -len(tries), None, left))
            left -= len(tries[-1])
        return tries

    def _fly(self, name: str, kind: str, number: int, equations: Equations | None, steps: int) -> Trajectory:
        """One trajectory; negative numbers are further tries of the first episode."""
        task = self.tasks[(number - 1) % len(self.tasks)] if number > 0 else None
        seed = [self.settings.seed, KINDS.index(kind), number % 2**16]
        rng = np.random.default_rng(seed)
        wrench = random_wrench(self.plant.robot, steps, rng) if kind == "pushed" else None
        what = f"{name.replace('_', ' ')}: {task.name if task else RANDOM_COMMANDS}"
        return self.record.episode(
            name,
            lambda: run_episode(
                self.plant,
                self._controller(task, equations, int(rng.integers(2**31))),
                task or self.tasks[0],
                seed=int(rng.integers(2**31)),
                steps=steps,
                wrench=wrench,
                on_step=lambda step, *_: self.on_progress(Progress(what, step + 1, steps)),
                name=name,
            ),
        )

    def _controller(self, task: Task | None, equations: Equations | None, seed: int) -> Controller:
        if task is None or equations is None:
            return RandomCommands(self.plant.robot, seed=seed)
        return mppi_controller(equations, self.plant.robot, task, samples=self.settings.samples, seed=seed)

    def _report(
        self, number: int, newest: Sequence[Trajectory], flown_by: Equations | None, seconds: float, fitted: float
    ) -> EpisodeReport:
        rows = sum(len(trajectory) for trajectory in newest)
        return EpisodeReport(
            number=number,
            task=self.tasks[(number - 1) % len(self.tasks)].name if number else RANDOM_COMMANDS,
            rows=rows,
            crashes=len(newest) - (rows == self.settings.steps),  # the last try ends with the steps, not on the ground
            tracking=tracking_error(newest[0]) if number else float("nan"),
            prediction=one_step_error(flown_by, newest) if flown_by else float("nan"),
            fitted=fitted,
            seconds=seconds,
            unit=unit_of_place(newest[0].layouts.state),
        )
