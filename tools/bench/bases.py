"""The three bases that an analyst may have: learned in the plain simulator, fitted to logs, or first principles."""

import tempfile
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

from answers import UNFORESEEN, Record, answer_of, refusal
from log_changes import every_second
from standard_set import Case, simulate_case

from sym2real.cli.results import plain_simulator
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.effects.visible import visible_state
from sym2real.errors import Sym2RealError
from sym2real.experiments.learning import learn_from_logs
from sym2real.experiments.measured import measured
from sym2real.experiments.models import cached_base
from sym2real.layout import Layout
from sym2real.logs import read_logs, write_log
from sym2real.robots import ROBOTS, car, quadrotor
from sym2real.robots.mushr import WHEELBASE
from sym2real.symbolic import Equations, load_model
from sym2real.symbolic.storage import save_model
from sym2real.tasks.task import flies

Kind = Literal["simulator", "logs", "first principles"]
HEALTHY_SEED = 6_900_000  # of the runs that a base is fitted to


@dataclass(frozen=True)
class Base:
    """A robot's base model; it travels to another process as text.

    Args:
        robot: name.
        kind: how it came about.
        text: the equations as JSON.
    """

    robot: str
    kind: Kind
    text: str

    @property
    def equations(self) -> Equations:
        """One object per text, so that what is compiled from it is kept."""
        return _parsed(self.text)


@lru_cache(maxsize=8)
def _parsed(text: str) -> Equations:
    return Equations.from_json(text)


def base_of(robot: str, kind: Kind, folder: Path, dt: float | None = None) -> Base:
    """A robot's base, as its verb of the command line makes it.

    Args:
        robot: name.
        kind: "simulator" learns it there, "logs" fits it to a set of eight noisy runs of the healthy robot.
        folder: keeps what was fitted.
        dt: time step of first principles in s; the robot's by default. What is learned keeps its own.
    """
    if kind == "simulator":
        equations = cached_base(ROBOTS[robot])
    elif kind == "logs":
        equations = _from_logs(robot, folder / f"base_{robot}")
    else:
        of = ROBOTS[robot]
        step = of.dt if dt is None else dt
        equations = quadrotor(of.mass, dt=step) if flies(of) else car(WHEELBASE, dt=step)
    return Base(robot, kind, equations.to_json())


def calibrated(base: Base) -> Base:
    """With what the healthy robot's runs say that it lacks: no simulator calibrates first principles."""
    of, equations = ROBOTS[base.robot], base.equations
    runs = simulate_case(Case(base.robot, seed=HEALTHY_SEED))
    runs = Dataset(map(every_second, runs)) if equations.dt > of.dt else runs
    found = diagnose(equations, as_read(equations, runs), plain_simulator(equations))
    return replace(base, text=found.apply(equations).to_json())


def _from_logs(robot: str, folder: Path) -> Equations:
    if not (folder / "equations.json").exists():
        with tempfile.TemporaryDirectory() as place:
            paths = written(simulate_case(Case(robot, seed=HEALTHY_SEED)), Path(place))
            save_model(learn_from_logs(measured(robot), paths, None, "beam").equations, folder)
    return load_model(folder)


def written(data: Dataset, folder: Path) -> list[Path]:
    """A CSV file per log, in their order; nobody has logged the wrench."""
    paths = [folder / f"log_{number:03}.csv" for number in range(len(data))]
    layouts = replace(data.layouts, inputs=Layout())
    for log, path in zip(data, paths, strict=True):
        write_log(replace(log, inputs=log.inputs[:, :0], layouts=layouts), path)
    return paths


def as_read(equations: Equations, data: Dataset) -> Dataset:
    """Logs as the command line gets them from files: at the model's step, with the model's columns, cut at gaps."""
    layouts = replace(equations.layouts, state=visible_state(equations))
    with tempfile.TemporaryDirectory() as place:
        return read_logs(written(data, Path(place)), layouts=layouts, dt=equations.dt)


def diagnosed(equations: Equations, data: Dataset) -> Record:
    """What ``sym2real diagnose`` says of logs, calibrated as there; a refusal is an answer too, and so is a crash."""
    try:
        logs = as_read(equations, data)
        return answer_of(diagnose(equations, logs, plain_simulator(equations)))
    except (Sym2RealError, *UNFORESEEN) as error:
        return refusal(error)
