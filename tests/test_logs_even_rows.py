"""Stamps that jitter about rows that were measured evenly are undone; those of rows that were not, stay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from sym2real.logs import read_log, write_log
from sym2real.logs.equal_steps import equal_steps
from sym2real.logs.even_rows import _even
from sym2real.robots import MUSHR
from sym2real.trajectory import Trajectory

DT, ROWS = 0.05, 300
EVENLY = 0.05 * np.arange(ROWS)
JITTER = 0.004


def drive(measured: NDArray[np.float64], stamps: NDArray[np.float64], noise: float = 1e-4) -> Trajectory:
    """A circle of 1 m at 1.5 rad/s, as it was at the times at which it was measured."""
    angle, rng = 1.5 * measured, np.random.default_rng(1)
    state = np.stack([np.sin(angle), -np.cos(angle), np.sin(angle), np.cos(angle)], axis=1)
    state = np.hstack([state, 1.5 * state[:, [3]], 1.5 * state[:, [2]], np.full((len(angle), 1), 1.5)])
    state += noise * rng.standard_normal(state.shape)
    action = np.column_stack([0.2 + 0.1 * np.sin(3 * measured), np.full(len(measured), 1.5)])
    return Trajectory(stamps, state, action, np.zeros((len(measured), 3)), MUSHR.layouts, name="drive")


def jittered(seed: int = 0) -> NDArray[np.float64]:
    return EVENLY + JITTER * np.random.default_rng(seed).uniform(-1.0, 1.0, ROWS)


def missed(log: Trajectory) -> float:
    """How far the car is from where it was at the log's times, m; any shift of all stamps is allowed."""
    angle = np.unwrap(np.arctan2(log.column("x"), -log.column("y")))
    return float(np.std(angle - 1.5 * log.time))


def told(log: Trajectory) -> bool:
    return any("measured evenly" in note for note in log.notes)


def test_rows_that_were_measured_evenly_are_taken_so() -> None:
    (log,) = equal_steps(drive(EVENLY, jittered()), DT)
    assert told(log)
    assert len(log) == ROWS
    assert missed(log) < 3e-4  # 0.004 rad by the stamps
    np.testing.assert_array_equal(log.action, drive(EVENLY, EVENLY).action)


def test_rows_that_were_measured_when_their_stamps_say_keep_them() -> None:
    (log,) = equal_steps(drive(jittered(), jittered()), DT)
    assert not told(log)
    assert missed(log) < 1e-3


def test_where_noise_hides_the_jitter_stamps_stay() -> None:
    (log,) = equal_steps(drive(EVENLY, jittered(), noise=0.05), DT)
    assert not told(log)


def test_even_stamps_are_not_touched() -> None:
    log = drive(EVENLY, EVENLY)
    assert equal_steps(log, DT) == [log]


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_are_lost_leave_the_others_where_they_were(seed: int) -> None:
    kept = np.sort(np.random.default_rng(seed).permutation(ROWS)[: ROWS - 12])
    (log,) = equal_steps(drive(EVENLY[kept], jittered(seed)[kept]), DT)
    assert told(log)
    assert missed(log) < 5e-4
    assert len(log) == pytest.approx(kept[-1] - kept[0] + 1, abs=1)


@pytest.mark.parametrize("seed", range(3))
def test_lost_rows_are_counted_though_stamps_jitter_by_half_a_step(seed: int) -> None:
    """Two rows of one tick were taken for rows that waited, and all others with them: ticks were 10.26 ms for 10."""
    rng = np.random.default_rng(seed)
    ticks = np.sort(rng.permutation(1500)[:1455])
    even = _even(0.01 * ticks + rng.uniform(-0.003, 0.003, len(ticks)))
    assert even is not None
    np.testing.assert_allclose(even - even[0], 0.01 * (ticks - ticks[0]), atol=3e-4)


def test_rows_that_came_in_bursts_are_counted() -> None:
    """Every tenth row waits for the next one and comes just before it; of a last row nobody knows whether it did."""
    late = EVENLY.copy()
    late[9:-1:10] += 0.95 * DT
    (log,) = equal_steps(drive(EVENLY, late), DT)
    assert told(log)
    assert missed(log) < 5e-4  # 0.02 rad by the stamps


def test_a_clock_that_runs_fast_keeps_its_step() -> None:
    (log,) = equal_steps(drive(EVENLY, 1.01 * jittered()))
    assert told(log)
    assert log.dt == pytest.approx(1.01 * DT, rel=1e-4)


def test_a_file_is_read_alike(tmp_path: Path) -> None:
    """And before anything is derived: velocities are slopes of what moves evenly."""
    write_log(drive(EVENLY, jittered()), tmp_path / "log.csv")
    (tmp_path / "spec.toml").write_text(
        'derive = ["velocity", "rate"]\n[time]\ncolumn = "time"\n[columns]\n'
        + "".join(f'{name} = "{name}"\n' for name in ("x", "y", "sin_yaw", "cos_yaw", "steer", "speed"))
    )
    log = read_log(tmp_path / "log.csv", tmp_path / "spec.toml", MUSHR.layouts, DT)
    assert told(log)
    speed = np.hypot(log.column("vx"), log.column("vy"))
    assert np.std(speed[2:-2]) < 4e-3  # 0.1 m/s by the stamps
