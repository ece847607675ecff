"""Figures of the base model: open-loop prediction, wrench inputs, closed loop, zero-shot.

Fresh seeds: nothing in the package was tuned on them. ``--quick`` leaves out the closed loop and the zero-shot flights.

    python tools/bench/base_model.py --quick
    python tools/bench/base_model.py --json build/base_model.json
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import torch
import tyro
from base_flown import CLOSED_LOOP_SEEDS, CM, STAGE_SEED, TEST_SEED, TRAIN_SEED, closed_loop, zero_shot
from figures import Figure, report, say
from wild_flights import reverse_drives, wild_drives, wild_flights

from sym2real.adaptation import StageOne, stage_one
from sym2real.dataset import Dataset
from sym2real.diagnosis import predict_windows
from sym2real.effects import effect
from sym2real.experiments.flights import car_drives, quadrotor_flights
from sym2real.experiments.learning import training_tasks
from sym2real.plants import MujocoPlant
from sym2real.regression import BeamSearch, dependence
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import Equations, compile_model
from sym2real.trajectory import Trajectory

HORIZON = 0.8

Section = Literal["quadrotor-flights", "quadrotor-stage-one", "car-stage-one", "zero-shot", "closed-loop"]


def position_errors(equations: Equations, data: Dataset) -> np.ndarray:
    """Position error in cm at the end of 0.8 s windows that start at the true state ``# (windows,)``."""
    model = compile_model(equations, dtype=torch.float64)
    steps = round(HORIZON / equations.dt)
    windows = [predict_windows(model, trajectory, steps, "measured").errors(steps) for trajectory in data]
    return CM * np.concatenate([errors["position"] for errors in windows])


def spread(name: str, errors: np.ndarray, median: str = "", p95: str = "") -> list[Figure]:
    """Median and 95th percentile as two figures."""
    return [
        Figure(f"{name}: median", float(np.median(errors)), "cm", median),
        Figure(f"{name}: p95", float(np.quantile(errors, 0.95)), "cm", p95),
    ]


def timed_fit(robot: Robot, data: Dataset) -> tuple[Equations, float]:
    """Equations and the CPU seconds of the search."""
    started = time.process_time()
    equations = BeamSearch(angles=robot.recipe.angles).fit(data.transitions())
    return equations, time.process_time() - started


def quadrotor_from_flights() -> list[Figure]:
    """Three flights of the geometric controller; tested in and out of distribution, and on pushed flights."""
    say("quadrotor: 3 flights of the geometric controller")
    flights = quadrotor_flights(3, TRAIN_SEED)
    equations, plain_seconds = timed_fit(CRAZYFLIE, flights)
    forced = quadrotor_flights(3, TRAIN_SEED + 1, forced=True)
    with_wrench, wrench_seconds = timed_fit(CRAZYFLIE, flights + forced)
    inside = position_errors(equations, quadrotor_flights(20, TEST_SEED))
    outside = position_errors(equations, wild_flights(20, TEST_SEED))
    wind = with_true_wrench(
        quadrotor_flights(3, TEST_SEED, changes=(effect("wind", CRAZYFLIE).inject(fx=0.03),)), {"fx": lambda _: 0.03}
    )
    offset = 0.002
    centre = with_true_wrench(
        quadrotor_flights(3, TEST_SEED, changes=(effect("com_offset", CRAZYFLIE).inject(rx=offset),)),
        {"ty": lambda trajectory: offset * trajectory.column("thrust")},
    )
    return [
        *spread("quadrotor, 3 flights, 0.8 s", inside, "< 0.05", "< 0.3"),
        *spread("quadrotor, 3 flights, out of distribution", outside, "< 2", "< 8"),
        Figure("quadrotor, wind 0.03 N given, RMS", rms(position_errors(with_wrench, wind)), "cm", "< 0.1"),
        Figure("quadrotor, centre of mass 2 mm given, RMS", rms(position_errors(with_wrench, centre)), "cm", "< 0.5"),
        Figure("quadrotor, search time, 13 equations", plain_seconds, "CPU s", "< 15"),
        Figure("quadrotor, search time with wrench", wrench_seconds, "CPU s", "< 30"),
        *structure("quadrotor, 3 flights", with_wrench, flights, CRAZYFLIE),
    ]


def structure(name: str, equations: Equations, data: Dataset, robot: Robot) -> list[Figure]:
    """Largest node count, and how many of the demanded dependences are missing."""
    missing = sum(not row.holds for row in dependence(equations, data.transitions(), robot.recipe.dependencies))
    return [
        Figure(f"{name}, largest equation", max(equations.complexity().values()), "nodes", "<= 85"),
        Figure(f"{name}, dependences missing", missing, "pairs", "<= 0"),
    ]


def rms(errors: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(errors**2)))


def with_true_wrench(data: Dataset, columns: dict[str, Callable[[Trajectory], object]]) -> Dataset:
    """The same trajectories with the wrench that acted, by column."""

    def given(trajectory: Trajectory) -> Trajectory:
        inputs = np.zeros_like(trajectory.inputs)
        for column, value in columns.items():
            inputs[:, trajectory.layouts.inputs.index(column)] = value(trajectory)
        return replace(trajectory, inputs=inputs)

    return Dataset(given(trajectory) for trajectory in data)


def quadrotor_from_stage_one() -> list[Figure]:
    """Three episodes of the Stage I loop."""
    say("quadrotor: 3 episodes of Stage I")
    settings = StageOne(3, pushed=False, until_settled=False, seed=STAGE_SEED)
    base = stage_one(MujocoPlant(CRAZYFLIE), training_tasks(CRAZYFLIE), BeamSearch(), settings)
    inside = position_errors(base.equations, quadrotor_flights(20, TEST_SEED))
    outside = position_errors(base.equations, wild_flights(20, TEST_SEED))
    return [
        *spread("quadrotor, 3 Stage I episodes, 0.8 s", inside, "< 0.3"),
        *spread("quadrotor, 3 Stage I episodes, out of distribution", outside, "< 4"),
        *structure("quadrotor, Stage I", base.equations, Dataset(base.episodes), CRAZYFLIE),
    ]


def car_from_stage_one() -> list[Figure]:
    """Five episodes of the Stage I loop, with and without wrench."""
    say("car: 5 episodes of Stage I, and 5 pushed")
    settings = StageOne(5, until_settled=False, seed=STAGE_SEED)
    base = stage_one(MujocoPlant(MUSHR), training_tasks(MUSHR), BeamSearch(angles=MUSHR.recipe.angles), settings)
    equations, plain_seconds = timed_fit(MUSHR, Dataset(base.episodes))
    with_wrench, wrench_seconds = timed_fit(MUSHR, Dataset(base.episodes + base.pushed))
    mass = float(sum(MujocoPlant(MUSHR).mj_model.body_mass))
    force = 2.0
    slope = with_true_wrench(
        car_drives(6, TEST_SEED, changes=(effect("slope", MUSHR).inject(gx=force / mass),)), {"fx": lambda _: force}
    )
    inside = position_errors(equations, car_drives(20, TEST_SEED))
    reverse = position_errors(equations, reverse_drives(20, TEST_SEED))
    fast = position_errors(equations, wild_drives(20, TEST_SEED))
    return [
        *spread("car, 5 Stage I episodes, 0.8 s", inside, "< 1.5", "< 4"),
        *spread("car, reverse driving", reverse, "", "< 20"),
        *spread("car, out of distribution (reverse; 2.2–4 m/s)", fast),
        Figure("car on a 2 N slope given, RMS", rms(position_errors(with_wrench, slope)), "cm", "< 2"),
        Figure("car, search time, 7 equations", plain_seconds, "CPU s", "< 5"),
        Figure("car, search time with wrench", wrench_seconds, "CPU s", "< 15"),
        *structure("car, Stage I", with_wrench, Dataset(base.episodes), MUSHR),
    ]


SECTIONS: dict[Section, Callable[[], list[Figure]]] = {
    "quadrotor-flights": quadrotor_from_flights,
    "quadrotor-stage-one": quadrotor_from_stage_one,
    "car-stage-one": car_from_stage_one,
    "zero-shot": zero_shot,
    "closed-loop": closed_loop,
}
SLOW = ("zero-shot", "closed-loop")


def main(quick: bool = False, only: tuple[Section, ...] = (), json: Path | None = None) -> None:
    """Measure the base model's figures.

    Args:
        quick: leave out closed loop and zero-shot.
        only: measure these sections alone.
        json: write the figures to this file (- is standard output).
    """
    torch.set_num_threads(1)
    chosen = only or [name for name in SECTIONS if not (quick and name in SLOW)]
    figures = [figure for name in chosen for figure in SECTIONS[name]()]
    report("base model", figures, [TRAIN_SEED, TEST_SEED, STAGE_SEED, *CLOSED_LOOP_SEEDS], json)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
