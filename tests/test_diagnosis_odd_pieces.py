"""Pieces unlike all others: accidents, or what a robot meets in one place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
from carriage import TEXT, carriage
from noisy_flights import flights_with
from weighed_problems import weighed_problems

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.unexplained.odd_pieces import find_where_odd
from sym2real.effects import effect
from sym2real.robots import CRAZYFLIE, Robot
from sym2real.trajectory import Trajectory

WALL = 0.5  # m


@pytest.fixture(scope="module")
def problems() -> Problems:
    base = CRAZYFLIE.nominal()
    return weighed_problems(Library.of(base, [effect("wind", base)]), flights_with("wind", {"fx": 0.01, "fy": 0.0}))


def unlike(problems: Problems, pieces: np.ndarray) -> Problems:
    trust = torch.ones(len(problems.problem.segments), dtype=torch.float64)
    trust[pieces] = 0.1
    return replace(problems, whitening=replace(problems.whitening, trust=trust))


def highest(problems: Problems) -> np.ndarray:
    """Pieces by how high the robot comes in them ``# (S,)``."""
    segments, place = problems.problem.segments, problems.data.layouts.state.index("z")
    rows = zip(segments.log, segments.row, strict=True)
    return np.argsort([problems.data[log].state[row : row + segments.length, place].max() for log, row in rows])


def test_pieces_at_one_end_of_what_is_measured_are_no_accidents(problems: Problems) -> None:
    ordered = highest(problems)
    count = len(ordered) // 4
    left = problems.problem.residuals(problems.library.null[None])[0]
    (found,) = find_where_odd(unlike(problems, ordered[-count:]), left)
    assert found.explained_by.startswith("height is above")
    assert found.term == f"{count} of {len(ordered)} pieces"
    (low,) = find_where_odd(unlike(problems, ordered[:count]), left)
    assert low.explained_by.startswith("height is below")


def test_as_many_anywhere_are_accidents_and_most_of_all_are_the_model_itself(problems: Problems) -> None:
    ordered = highest(problems)
    left = problems.problem.residuals(problems.library.null[None])[0]
    for seed in range(20):
        anywhere = np.random.default_rng(seed).permutation(len(ordered))[: len(ordered) // 4]
        assert find_where_odd(unlike(problems, anywhere), left) == ()
    assert find_where_odd(unlike(problems, ordered[len(ordered) // 4 :]), left) == ()
    assert find_where_odd(unlike(problems, ordered[:0]), left) == ()


def driven(robot: Robot, seed: int, stop: float) -> Trajectory:
    """By a force of three sines and a weak spring, in a MuJoCo whose rail ends at a stop."""
    model = mujoco.MjModel.from_xml_string(
        TEXT.format(damping=1.0, most=20.0, stiffness=0.0).replace('range="-9 9"', f'range="-9 {stop}" limited="true"')
    )
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    frequency, phase = rng.uniform(1.0, 6.0, 3), rng.uniform(0, 2 * np.pi, 3)
    states, actions = np.empty((400, 2)), np.empty((400, 1))
    for step in range(400):
        force = 1.6 * np.sin(frequency * step * robot.dt + phase).sum() - 4.0 * data.qpos[0]
        data.ctrl[:] = actions[step] = np.clip(force, -20, 20)
        states[step] = np.concatenate([data.qpos, data.qvel]) + rng.normal(0, [0.001, 0.005])
        for _ in range(20):
            mujoco.mj_step(model, data)
    return Trajectory.from_arrays(states, actions, robot.layouts, dt=robot.dt, name=f"run {seed}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stop", "verdict"),
    [(WALL, "UNEXPLAINED"), (0.15, "UNEXPLAINED"), (9.0, "NOTHING_MISSING")],
    ids=["wall", "near", "free"],
)
def test_a_wall_that_is_struck_now_and_then_is_missing_where_it_stands(
    tmp_path: Path, stop: float, verdict: str
) -> None:
    robot = carriage(tmp_path, damping=1.0, most=20.0)
    logs = Dataset([driven(robot, seed, stop) for seed in range(6)])
    reached = max(log.column("rail").max() for log in logs)
    assert reached > min(0.98 * stop, 1.05 * WALL)
    found = diagnose(robot.nominal(), logs)
    assert found.verdict == verdict, found.summary
    if verdict == "UNEXPLAINED":
        name, _, value = found.leftovers[0].explained_by.partition(" is above ")
        assert name == "rail"
        assert float(value) == pytest.approx(stop, rel=0.1)
