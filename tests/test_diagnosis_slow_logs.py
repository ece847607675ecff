"""Logs slower than the model: nothing between their rows is made up, and the answer is that of the robot."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, add, compare, diagnose
from sym2real.diagnosis.estimate.simulator import with_effects_of
from sym2real.diagnosis.faults.mistakes.lost_commands import _smooth, with_lost_commands
from sym2real.effects.sensors import MeasuredModel
from sym2real.errors import ShapeError
from sym2real.logs import read_log, read_logs, write_log
from sym2real.plants import MujocoPlant
from sym2real.robots import MUSHR

PERIOD = 0.1  # s, of commands and rows; the model's step is half of that
DELAY = 0.15


def diagnosed(folder: Path, drives: int, rows: int, *effects: tuple[str, Mapping[str, float]]) -> Diagnosis:
    """Noisy drives commanded and logged at 10 Hz, through files."""
    data = simulate_case(Case("mushr", effects, seed=41), drives, rows, robot=MUSHR.at_period(PERIOD))
    for number, log in enumerate(data):
        write_log(log, folder / f"{number}.csv")
    model = MUSHR.nominal()
    logs = read_logs(folder, layouts=model.layouts, dt=model.dt)
    assert logs.dt == pytest.approx(PERIOD)
    assert logs.rows == data.rows
    return diagnose(model, logs, MujocoPlant(MUSHR))


@pytest.mark.slow
def test_a_healthy_car_at_half_the_models_rate_misses_nothing(tmp_path: Path) -> None:
    assert diagnosed(tmp_path, 4, 200).verdict == "NOTHING_MISSING"


@pytest.mark.slow
def test_a_delay_between_two_rows_is_found_to_a_fraction_of_a_row(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 6, 120, ("delay:steer", {"value": DELAY}))
    assert [finding.effect for finding in found.findings] == ["delay:steer"]
    assert found.findings[0].values["value"] == pytest.approx(DELAY, abs=0.2 * PERIOD)
    before, after = found.ladder[0], found.ladder[-1]
    assert after.horizons[0.8]["position"].value < 0.5 * before.horizons[0.8]["position"].value
    logs = read_logs(tmp_path, layouts=MUSHR.layouts, dt=MUSHR.dt)
    models = MUSHR.nominal(), found.apply(MUSHR.nominal())
    errors = [compare(model, logs).at(0.8).errors["position"].value for model in models]
    assert errors[1] < 0.5 * errors[0]


def test_a_model_that_delays_is_held_against_a_simulator_that_delays_as_much() -> None:
    late = add(MUSHR.nominal(), "delay:steer", {"value": DELAY})
    plant, _ = with_effects_of(late, MujocoPlant(MUSHR), PERIOD)
    assert plant is not None
    rates = []
    plant.reset(MUSHR.start)
    for row in range(12):
        rates.append(plant.step(np.array([0.0 if row < 6 else 0.3, 1.0]))[MUSHR.layouts.state.index("wz")])
    # Sent at row 6, half a row of 0.1 s before the row after the next.
    turning = np.flatnonzero(np.abs(rates) > 0.05)[0]
    assert turning in (7, 8)


def test_rows_far_apart_are_compared_at_horizons_that_they_have() -> None:
    data = simulate_case(Case("mushr", seed=1), trajectories=1, rows=80, robot=MUSHR.at_period(0.2))
    found = compare(MUSHR.nominal(), data)
    assert [errors.horizon for errors in found.horizons] == [0.2, 0.8, 1.0]
    assert any("taken as held" in line for line in found.data.lines())  # type: ignore[union-attr]


def written(folder: Path, name: str, dt: float, seconds: float = 4.0) -> Path:
    time = np.arange(round(seconds / dt)) * dt
    columns = {"time": time, "x": time, "y": 0 * time, "vx": 1 + 0 * time, "vy": 0 * time, "steer": np.sin(time)}
    np.savetxt(
        folder / name, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments=""
    )
    return folder / name


def test_logs_get_the_step_of_the_slowest_and_the_models_where_that_is_asked(tmp_path: Path) -> None:
    fast, slow = written(tmp_path, "fast.csv", 0.05), written(tmp_path, "slow.csv", 0.125)
    assert [log.dt for log in read_logs([fast, slow], dt=0.05)] == pytest.approx([0.125, 0.125])
    assert len(read_log(slow, dt=0.05)) == 32  # every row as it was measured
    assert [log.dt for log in read_logs([fast, slow], dt=0.05, upsample=True)] == pytest.approx([0.05, 0.05])
    assert read_log(fast, dt=0.125).dt == pytest.approx(0.125)


def test_a_residual_is_held_against_rows_of_its_own_step_alone(tmp_path: Path) -> None:
    data = simulate_case(Case("mushr", seed=1), trajectories=1, rows=60, robot=MUSHR.at_period(PERIOD))
    whole = MeasuredModel(MUSHR.nominal())
    whole.equations = MUSHR.nominal()  # type: ignore[attr-defined]
    with pytest.raises(ShapeError, match=r"0\.05 s, the log's is 0.1 s: read it with dt=0.05, upsample=True"):
        compare(whole, data)


def every_second_row(data: Dataset, folder: Path) -> Dataset:
    """Of drives at the model's own rate, through files: half of the commands are nowhere."""
    for number, log in enumerate(data):
        rows = slice(0, None, 2)
        parts = {name: getattr(log, name)[rows] for name in ("time", "state", "action", "inputs")}
        write_log(replace(log, **parts, extra={}), folder / f"{number}.csv")
    return read_logs(folder, layouts=MUSHR.layouts, dt=MUSHR.dt)


@pytest.mark.slow
def test_a_delay_keeps_its_value_where_half_of_the_commands_are_lost(tmp_path: Path) -> None:
    """Commands that are held over a row are late by half of it, and so much less would be left for the delay."""
    data = simulate_case(Case("mushr", (("delay", {"value": 0.1}),), seed=42), 4)
    found = diagnose(MUSHR.nominal(), every_second_row(data, tmp_path), MujocoPlant(MUSHR)).findings
    assert [finding.effect for finding in found] == ["delay"]
    assert found[0].values["value"] == pytest.approx(0.1, abs=0.01)


@pytest.mark.slow
def test_commands_that_a_recorder_lost_are_no_effect(tmp_path: Path) -> None:
    data = simulate_case(Case("mushr", (("yaw_bias", {"value": 0.035}),), seed=41), 4)
    model, logs = MUSHR.nominal(), every_second_row(data, tmp_path)
    thinned, whole = with_lost_commands(model, logs), with_lost_commands(model, data)
    between = [log.between for log in thinned]
    assert all(parts is not None and parts.shape == (200, 2, 2) for parts in between)
    assert all(log.between is None for log in whole)
    # What is expected of the commands that were lost is nearer to them than those that were kept.
    lost = np.concatenate([log.action[1::2] for log in data])
    expected = np.concatenate([parts[:, 1] for parts in between if parts is not None])
    kept = np.concatenate([log.action[::2] for log in data])
    assert (np.square(expected - lost).mean(0) < np.square(kept - lost).mean(0)).all()
    assert "yaw_bias" in [finding.effect for finding in diagnose(model, logs, MujocoPlant(MUSHR)).findings]


def test_commands_that_are_held_stay_as_they_are() -> None:
    held = simulate_case(Case("mushr", seed=41), trajectories=2, rows=200, robot=MUSHR.at_period(PERIOD))
    assert with_lost_commands(MUSHR.nominal(), held) is held


def test_a_command_between_rows_may_be_taken_half_way_to_the_smooth_one() -> None:
    (log,) = simulate_case(Case("mushr", seed=41), trajectories=1, rows=100)
    half, whole = (_smooth(log, 2, part).between for part in (0.5, 1.0))
    assert half is not None
    assert whole is not None
    np.testing.assert_array_equal(half[:, 0], log.action)
    np.testing.assert_allclose(half[:, 1], (log.action + whole[:, 1]) / 2, atol=1e-12)
