"""An effect drawn by seed that a robot has and its model lacks: logs with it, and flights with models that lack it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from sym2real.control import mppi_controller
from sym2real.effects import effect
from sym2real.experiments.flying import Flight, fly
from sym2real.experiments.standard_cases import standard_cases
from sym2real.experiments.standard_set import Case, simulate_case
from sym2real.logs import write_log
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations
from sym2real.tasks import make_task


def hidden_case(robot: str, seed: int) -> Case:
    """A single effect of the standard set in one of its sizes; the flights' own noise and trim go with the seed."""
    singles = [case for case in standard_cases(robot) if len(case.effects) == 1]
    drawn = singles[int(np.random.default_rng(seed).integers(len(singles)))]
    return replace(drawn, seed=seed)


def write_flights(case: Case, folder: Path, flights: int, rows: int) -> list[Path]:
    """Simulate the case and write a CSV log per flight; nothing in them names the effect."""
    paths = []
    for trajectory in simulate_case(case, flights, rows):
        paths.append(folder / f"{trajectory.name}.csv")
        write_log(trajectory, paths[-1])
    return paths


def flown_with(
    case: Case,
    models: Mapping[str, Equations],
    tasks: Iterable[str],
    *,
    seconds: float,
    samples: int | None = None,
    seed: int = 0,
) -> list[Flight]:
    """Every task flown by MPPI with every model in the plant that has the effect, named "task, model"."""
    robot, flights = ROBOTS[case.robot], []
    changes = [effect(key, robot).inject(**values) for key, values in case.effects]
    for task_name in tasks:
        task = make_task(task_name, robot)
        for label, equations in models.items():
            controller = mppi_controller(equations, robot, task, samples=samples, seed=seed)
            name = f"{task_name}, {label}"
            flights.append(fly(MujocoPlant(robot, changes), controller, task, seconds=seconds, seed=seed, name=name))
    return flights
