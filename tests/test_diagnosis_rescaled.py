"""A command in no unit that is known has one factor: what a search finds beside the first look at it belongs to it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from carriage import Regulator, carriage

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.faults.sanity import check
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import Robot
from sym2real.trajectory import Array, Trajectory

LOGGED, NOISE = 0.05, np.array([2e-3, 0.15])


class AnswersNoise(Regulator):
    """A regulator of what its sensors report, so that its command goes with their noise."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.reported, self.goal = rng, list[Array](), 0.0

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        self.goal = self.rng.uniform(-1.0, 1.0) if step % 40 == 0 else self.goal
        self.reported.append(state + NOISE * self.rng.standard_normal(2))
        return np.array([12.0, 6.0]) @ (np.array([self.goal, 0.0]) - self.reported[-1])[None].T


def driven(robot: Robot, number: int) -> Trajectory:
    regulator = AnswersNoise(np.random.default_rng(number))
    log = run_episode(MujocoPlant(robot), regulator, start=np.zeros(2), steps=400)
    return replace(log, state=np.stack(regulator.reported), action=LOGGED * log.action, name=f"log{number}")


def test_the_factor_of_a_healthy_robots_command_is_told_exactly_and_no_gain_beside_it(tmp_path: Path) -> None:
    robot = carriage(tmp_path, damping=2.0, most=20.0)
    logs = Dataset(driven(robot, number) for number in range(4))
    (first,) = check(robot.nominal(), logs).faults
    assert first.columns == ("drive",)
    assert first.value is not None
    assert abs(first.value / LOGGED - 1.0) > 0.02  # noise that is answered looks like what the command does
    found = diagnose(robot.nominal(), logs)
    (fault,) = found.faults
    assert found.findings == ()
    assert fault.value == pytest.approx(LOGGED, rel=0.01)
    assert f"scale = {1.0 / fault.value:.4g} " in fault.fix
