"""Rows that a log has lost while commands changed: nobody knows what was sent, and no prediction across them tells."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from carriage import Regulator, carriage

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.errors.rungs import HeldOut
from sym2real.diagnosis.predict.library import Library
from sym2real.effects import effect
from sym2real.logs import read_logs, write_log
from sym2real.logs.resample import BRIDGED
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import Robot
from sym2real.trajectory import Array

NOISE = np.array([2e-4, 5e-3])


class Wandering(Regulator):
    """A regulator whose command changes in every row."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.goal = rng, 0.0

    def act(self, state: Array, step: int, inputs: Array | None = None) -> Array:
        self.goal = self.rng.uniform(-1.0, 1.0) if step % 40 == 0 else self.goal
        return np.array([8.0 * (self.goal - state[0]) - 4.0 * state[1] + 4.0 * self.rng.standard_normal()])


def recorded(folder: Path, robot: Robot, lost: float, gain: float = 1.0) -> Dataset:
    """Files of drives without a part of their rows, as they are read."""
    changes = [effect("gain:drive", robot).inject(value=gain)]
    for number in range(4):
        rng = np.random.default_rng(number)
        log = run_episode(MujocoPlant(robot, changes), Wandering(rng), start=np.zeros(2), steps=600)
        file, noise = folder / f"drive{number}.csv", NOISE * rng.standard_normal(log.state.shape)
        write_log(replace(log, state=log.state + noise), file)
        names, *rows = file.read_text().splitlines(keepends=True)
        file.write_text(names + "".join(row for row in rows if rng.uniform() >= lost))
    return read_logs(sorted(folder.glob("drive*.csv")), layouts=robot.layouts, dt=robot.dt)


def test_a_gain_is_named_though_rows_are_lost(tmp_path: Path) -> None:
    """Predictions across a row whose command nobody knows were as wrong with the gain as without."""
    robot = carriage(tmp_path, damping=0.1, most=20.0)
    logs = recorded(tmp_path, robot, lost=0.04, gain=0.85)
    assert sum(int(log.extra[BRIDGED].sum()) for log in logs) > 50
    found = diagnose(robot.nominal(), logs)
    assert found.verdict == "EFFECT", found.summary
    assert found.findings[0].effect == "gain:drive"
    value = found.findings[0].parameters["value"]
    assert value.value == pytest.approx(0.85, abs=0.02)


def test_errors_are_those_of_windows_that_lost_nothing(tmp_path: Path) -> None:
    robot = carriage(tmp_path, damping=0.1, most=20.0)
    (tmp_path / "whole").mkdir()
    whole = recorded(tmp_path / "whole", robot, lost=0.0)
    assert not any(BRIDGED in log.extra for log in whole)
    library = Library.of(robot.nominal(), [])
    horizons = HeldOut(library, whole).horizons(0.5)
    errors = []
    for logs in (whole, recorded(tmp_path, robot, lost=0.04)):
        (rung,) = HeldOut(library, logs).ladder([("base", library.null[None])], horizons)
        errors.append([float(error.value) for at in horizons for error in rung.horizons[at].values()])
    np.testing.assert_allclose(errors[1], errors[0], rtol=0.25)
