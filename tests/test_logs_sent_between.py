"""A log whose positions come more rarely than its commands: all commands are played, in parts of a row."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.mistakes.lost_commands import step_likelihood
from sym2real.diagnosis.faults.mistakes.transformation import Exchanged, Late, as_meant
from sym2real.diagnosis.faults.sanity import check
from sym2real.logs import LogSpec, read_log, read_logs
from sym2real.robots import MUSHR
from sym2real.trajectory import Array, Trajectory

PARTS = 4
PERIOD = 0.025  # s, of commands; a pose is new every fourth row


def written(path: Path, log: Trajectory, parts: int = PARTS, unit: float = 1.0) -> Path:
    """Rows of commands with the pose repeated until it is new, as a logger of a slower receiver writes them."""
    last = np.arange(len(log)) // parts * parts
    yaw = np.arctan2(log.column("sin_yaw"), log.column("cos_yaw"))
    columns = {"time": log.time, "x": log.column("x")[last], "y": log.column("y")[last], "yaw": yaw[last]}
    columns |= {"steer": log.column("steer") * unit, "speed": log.column("speed")}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return path


@pytest.fixture(scope="module")
def driven() -> Trajectory:
    (log,) = simulate_case(Case("mushr", seed=5), 1, 600, robot=MUSHR.at_period(PERIOD))
    return log


SPEC = LogSpec.parse("""
derive = ["velocity", "rate"]
[time]
column = "time"
[columns]
x = {column = "x"}
y = {column = "y"}
yaw = {column = "yaw"}
steer = {column = "steer"}
speed = {column = "speed"}
""")


def in_rows(log: Trajectory) -> Array:
    assert log.between is not None
    return log.between.reshape(-1, log.action.shape[1])


def test_commands_of_rows_without_a_new_pose_stand_between_the_rows_that_have_one(
    driven: Trajectory, tmp_path: Path
) -> None:
    log = read_log(written(tmp_path / "drive.csv", driven), SPEC, MUSHR.layouts, dt=PERIOD)
    assert log.dt == pytest.approx(PARTS * PERIOD)
    sent = in_rows(log)
    np.testing.assert_allclose(sent, driven.action[: len(sent)], atol=1e-12)
    np.testing.assert_allclose(log.action, sent.reshape(len(log), PARTS, 2).mean(1), atol=1e-12)


def test_units_and_signs_of_the_specification_are_those_of_every_command(driven: Trajectory, tmp_path: Path) -> None:
    path = written(tmp_path / "drive.csv", driven, unit=-180.0 / np.pi)
    columns = {**SPEC.columns, "steer": replace(SPEC.columns["steer"], unit="deg")}
    log = read_log(path, replace(SPEC, columns=columns, flip=("steer",)), MUSHR.layouts, dt=PERIOD)
    np.testing.assert_allclose(in_rows(log)[:, 0], driven.column("steer")[: PARTS * len(log)], atol=1e-9)


def test_a_pose_in_every_row_has_nothing_between(driven: Trajectory, tmp_path: Path) -> None:
    log = read_log(written(tmp_path / "drive.csv", driven, parts=1), SPEC, MUSHR.layouts, dt=PERIOD)
    assert log.between is None


def test_a_mistake_is_undone_between_rows_as_in_them(driven: Trajectory, tmp_path: Path) -> None:
    log = read_log(written(tmp_path / "drive.csv", driven), SPEC, MUSHR.layouts, dt=PERIOD)
    sent = in_rows(log)
    mirrored = as_meant(Exchanged(("steer",), ("steer",), (-1,)), log)
    np.testing.assert_array_equal(in_rows(mirrored), sent * [-1.0, 1.0])
    later = as_meant(Late("commands", ("steer", "speed"), 1, log.dt), log)
    np.testing.assert_allclose(in_rows(later)[:-PARTS], sent[PARTS:], atol=1e-12)


def test_what_was_sent_between_rows_predicts_better_than_its_mean(tmp_path: Path) -> None:
    data = simulate_case(Case("mushr", seed=6), 2, 600, robot=MUSHR.at_period(PERIOD))
    paths = [written(tmp_path / f"{number}.csv", log) for number, log in enumerate(data)]
    model = MUSHR.at_period(PERIOD).nominal()
    logs = read_logs(paths, SPEC, MUSHR.layouts, dt=PERIOD)
    checked = check(model, logs)
    assert not checked.faults and not checked.commands_lost
    assert any("played as logged" in line for line in checked.notes)
    means = Dataset(replace(log, between=None) for log in logs)
    assert step_likelihood(model, logs) > step_likelihood(model, means) + 5.0
