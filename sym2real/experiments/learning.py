"""Learning a base model, from a plain simulator or from logs, with what a person wants to know of the result."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from sym2real.adaptation import EpisodeReport, Progress, StageOne, stage_one
from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.sensor_readings import readings
from sym2real.errors import DataError
from sym2real.experiments.excitation import dithered
from sym2real.experiments.flights import car_drives
from sym2real.experiments.measured import Measured, step_of
from sym2real.files import write_text
from sym2real.layout import Layouts
from sym2real.level_ground import PLACE, any_heading_alike, at_many_headings
from sym2real.logs import LogSpec, read_logs
from sym2real.logs.differences import differences, rates_on_time
from sym2real.logs.reader import logs_of, read_each
from sym2real.plants import MujocoPlant, run_episode
from sym2real.regression import ENGINES, BeamSearch, Dependence, dependence
from sym2real.regression.numeric import columns_of
from sym2real.regression.selection import SearchSettings
from sym2real.regression.windows import MEASURED
from sym2real.regression.wrench import FEWEST_ROWS
from sym2real.robots import Robot
from sym2real.symbolic import Equations, save_model
from sym2real.symbolic.storage import TRAINING, training_of
from sym2real.tasks import Task, make_task
from sym2real.vocabulary import ATTITUDE

DRIVES_SEED, WRENCH_DRIVES = 1, 3
# Of measured logs, tuned on noisy runs: .07 leaves the thrust out of a hover's equations, .03 takes noise for terms.
PARSIMONY = 0.05
# What a model notes that has the robot's own faults in it already, so that no plain simulator can calibrate it.
FROM_LOGS = "fitted to recorded logs: what was wrong with the robot there is in the equations"


@dataclass(frozen=True)
class Learned:
    """A base model and how it came about.

    Args:
        equations: the model.
        dependence: how strongly each action reaches the states that it must.
        region: smallest and largest value of every state and action column in the training rows.
        reports: of the episodes, when it was learned in a simulator.
    """

    equations: Equations
    dependence: tuple[Dependence, ...]
    region: dict[str, tuple[float, float]]
    reports: tuple[EpisodeReport, ...] = ()

    def save(self, folder: Path) -> None:
        """Write the model folder, with ``training.json`` beside the equations."""
        training = {
            "dependence": [asdict(row) for row in self.dependence],
            "region": self.region,
            "episodes": [asdict(report) for report in self.reports],
        }
        write_text(folder / TRAINING, json.dumps(training, indent=1))
        save_model(self.equations, folder)  # last: a cached base is there when its equations are


@dataclass(frozen=True)
class Trained:
    """What ``training.json`` says of dependence."""

    dependence: list[Dependence] = field(default_factory=list)


def trained_dependence(folder: Path) -> list[Dependence]:
    """How strongly each action reaches the states, as ``training.json`` of a model folder has it; empty without.

    Raises:
        DataError: when it cannot be read.
    """
    return training_of(folder, Trained).dependence


def training_tasks(robot: Robot) -> list[Task]:
    """The tasks that a robot's base model is learned on."""
    return [make_task(name, robot, **options) for name, options in robot.recipe.tasks]


def learn_in_simulation(
    robot: Robot,
    engine: str,
    settings: StageOne,
    folder: Path | None,
    on_progress: Callable[[Progress], None],
) -> Learned:
    """Stage I in the robot's plain simulator; ``folder`` keeps the episodes and lets an interrupted run go on.

    Raises:
        UnknownNameError: for an engine that does not exist.
        ModelError: when the equations miss a dependence that control needs.
    """
    search = ENGINES[engine](angles=robot.recipe.angles)
    plant, tasks = MujocoPlant(robot), training_tasks(robot)
    base = stage_one(plant, tasks, search, settings, folder=folder, on_progress=on_progress)
    data = Dataset(base.episodes + base.pushed)
    return _learned(base.equations, data, robot.recipe.dependencies, base.reports)


def from_description(robot: Robot) -> Learned:
    """A robot's nominal equations, beside what its regulator's runs of the training tasks cover."""
    runs = []
    for number, task in enumerate(training_tasks(robot)):
        sent = dithered(geometric_controller(robot, task.reference), robot, np.random.default_rng(number))
        runs.append(run_episode(MujocoPlant(robot), sent, task, seed=number, name=task.name))
    return _learned(robot.nominal(), Dataset(runs), robot.recipe.dependencies, ())


def learn_from_drives(robot: Robot, count: int) -> Learned:
    """A car's equations from so many drives in its plain simulator, steered by pure pursuit and at random.

    Three further drives are under a random wrench and teach its inputs.
    """
    drives = car_drives(count, DRIVES_SEED, robot=robot)
    drives += car_drives(WRENCH_DRIVES, DRIVES_SEED + 1, forced=True, robot=robot)
    fitted = ENGINES["beam"](angles=robot.recipe.angles).fit(drives.transitions())
    return _learned(robot.signed(fitted), drives, robot.recipe.dependencies, ())


def learn_from_logs(
    robot: Measured,
    paths: Sequence[Path],
    spec: LogSpec | None,
    engine: str,
    *,
    numbers: Mapping[str, float] | None = None,
    on_progress: Callable[[str], None] = lambda _: None,
) -> Learned:
    """Equations fitted to recorded logs; ``dependence`` shows what control cannot rely on.

    Args:
        robot: whose columns the logs have; one without a step of its own takes that of the logs.
        paths: of the logs.
        spec: how their columns are named.
        engine: of the search.
        numbers: of the robot that was measured (mass in kg, …), where they are not those that are known.
        on_progress: told what is being done.

    Raises:
        DataError: when a log cannot be read or lacks a column of the robot, or all are too short.
        UnknownNameError: for an engine or specification that does not exist.
    """
    like, known = robot
    layouts = Layouts(like.layouts.state, like.layouts.action)  # nobody knows the wrench of a log
    step = like.dt if known else step_of(read_each(logs_of(paths, spec), spec, layouts, None))
    data = read_logs(paths, spec=spec, layouts=layouts, dt=step, upsample=True)
    if (steps := data.rows - len(data)) < FEWEST_ROWS:
        raise DataError(", ".join(map(str, paths)), f"at least {FEWEST_ROWS} steps to learn from", f"{steps}")
    data, late = _on_time(data)
    search = ENGINES[engine](angles=like.recipe.angles)
    turned = any_heading_alike(layouts)
    if isinstance(search, BeamSearch):
        search = replace(
            search,
            windows=MEASURED,
            cyclic=PLACE if turned else (),
            search=SearchSettings(parsimony=PARSIMONY),
            on_column=lambda column: on_progress(f"searching the equation of {column}"),
        )
    on_progress(f"searching equations in {data.rows} rows of {step:g} s")
    equations = search.fit(at_many_headings(data) if turned else data.transitions())
    given = {**(like.numbers if known else {}), **(numbers or {})}
    name, notes = like.name if known else "", (*equations.notes, FROM_LOGS, *late)
    own = replace(equations, dt=step, robot=name, numbers=given, notes=notes)
    return _learned(own, data, like.recipe.dependencies, ())


def _on_time(data: Dataset) -> tuple[Dataset, tuple[str, ...]]:
    """The logs with velocities and joint rates at the times when they were true, and what is said of it.

    Differences of what was measured are half a row late, filtered ones later. An equation cannot hold a delay of its
    own: it would take it for slowness of the robot.
    """
    moved, data = ", ".join(differences(data)), rates_on_time(data)
    notes = [f"{moved}: slopes at the rows, in the place of differences, half a row late"] if moved else []
    for reading in readings(data, honest=0.0):
        late = replace(reading, scale=1.0, bias=0.0)
        if reading.of != ATTITUDE.name and late.shift:
            data = Dataset(late.undone(log) for log in data)
            notes.append(f"{late.column} of the logs is {1e3 * late.shift:.0f} ms late, and was moved")
    return data, tuple(notes)


def _learned(
    equations: Equations, data: Dataset, pairs: Iterable[tuple[str, str]], reports: tuple[EpisodeReport, ...]
) -> Learned:
    transitions = data.transitions()
    known, names = columns_of(transitions), (*data.layouts.state, *data.layouts.action)
    region = {name: (float(known[name].min()), float(known[name].max())) for name in names}
    return Learned(equations, tuple(dependence(equations, transitions, pairs)), region, reports)
