"""Rows at equal steps: against analytic signals, with commands that hold, and never across a gap."""

from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from sym2real import rotation
from sym2real.errors import DataError
from sym2real.layout import Layout, Layouts
from sym2real.logs import read_log, read_logs, write_log
from sym2real.logs.equal_steps import equal_steps
from sym2real.logs.resample import GAP_INTERVALS
from sym2real.trajectory import Trajectory

Array = NDArray[np.float64]
LAYOUTS = Layouts(
    Layout.of(["x", "qw", "qx", "qy", "qz", "sin_yaw", "cos_yaw"]), Layout.of(["thrust"]), Layout.of(["vbat", "t"])
)
RATE = np.array([0.9, -0.4, 2.0])


def motion(time: Array) -> tuple[Array, Array, Array, Array]:
    """Constant speed, constant body rate, constant yaw rate (many turns), and a command that changes at each row."""
    quaternion = rotation.exponential(torch.from_numpy(np.outer(time, RATE))).numpy()
    yaw = 7.0 * time
    return 3.0 * time - 1.0, quaternion, np.stack([np.sin(yaw), np.cos(yaw)], axis=1), np.arange(len(time)) + 1.0


def log_at(time: Array) -> Trajectory:
    x, quaternion, circle, command = motion(time)
    state = np.column_stack([x, quaternion, circle])
    inputs = np.column_stack([4.0 - 0.1 * time, time])
    extra = {"ref_x": 2.0 * time, "counter": np.arange(len(time)) + 0.0}
    return Trajectory(time, state, command[:, None], inputs, LAYOUTS, extra=extra, name="log")


def reread(folder: Path, time: Array, dt: float | None) -> Trajectory:
    write_log(log_at(time), folder / "log.csv")
    return read_log(folder / "log.csv", layouts=LAYOUTS, dt=dt, upsample=True)


def jittered(seed: int, rows: int = 200, dt: float = 0.02, share: float = 0.3) -> Array:
    return np.cumsum(dt * (1 + np.random.default_rng(seed).uniform(-share, share, rows)))


def assert_on_the_motion(log: Trajectory) -> None:
    x, quaternion, circle, _ = motion(log.time)
    assert np.allclose(log.state[:, 0], x, atol=1e-12)
    assert np.allclose(np.abs(np.sum(log.state[:, 1:5] * quaternion, axis=1)), 1, atol=1e-12)
    assert np.allclose(log.state[:, 5:7], circle, atol=1e-10)
    assert np.allclose(log.inputs, np.column_stack([4.0 - 0.1 * log.time, log.time]), atol=1e-12)
    assert np.allclose(log.extra["ref_x"], 2 * log.time)


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.013])
def test_jittered_stamps_follow_the_motion_exactly(tmp_path: Path, dt: float) -> None:
    time = jittered(1)
    log = reread(tmp_path, time, dt)
    assert np.allclose(np.diff(log.time), dt, rtol=1e-9)
    assert log.time[0] == time[0]
    assert time[-1] - dt < log.time[-1] <= time[-1] + 1e-9
    assert_on_the_motion(log)
    assert any("resampled" in note for note in log.notes)
    # What was recorded is still there.
    assert np.array_equal(log.raw["time"], time)
    assert np.array_equal(log.raw["thrust"], np.arange(len(time)) + 1.0)


def test_jittered_commands_hold_the_value_in_force_in_the_middle_of_the_step(tmp_path: Path) -> None:
    time = jittered(2)
    log = reread(tmp_path, time, 0.02)
    for stamp, command in zip(log.time, log.action[:, 0], strict=True):
        assert command == 1 + max(i for i, sent in enumerate(time) if sent < stamp + 0.01)
    assert set(log.action[:, 0]) <= set(log.raw["thrust"])


@pytest.mark.parametrize("dt", [0.024, 0.05])
def test_a_command_is_the_mean_of_what_was_in_force_in_its_step(tmp_path: Path, dt: float) -> None:
    time = jittered(2)
    log = reread(tmp_path, time, dt)
    parts = 2000
    for stamp, command in zip(log.time, log.action[:, 0], strict=True):
        moments = stamp + dt * (np.arange(parts) + 0.5) / parts
        assert command == pytest.approx(np.searchsorted(time, moments, side="right").mean(), abs=2 * dt / 0.01 / parts)


def test_jitter_delays_no_command_on_average(tmp_path: Path) -> None:
    """A ramp of commands, resampled, lags its own stamps by far less than a step."""
    time = jittered(3, rows=2000, share=0.4)
    log = reread(tmp_path, time, 0.02)
    sent_at = np.interp(log.action[:, 0] - 1, np.arange(len(time)), time)
    assert abs(np.mean(log.time - sent_at)) < 0.1 * 0.02


RAMP = 20.0  # 1/s, by which a command grows that is sent in steps


def polled(folder: Path, period: float, first: float) -> tuple[Trajectory, float]:
    """A ramp that is sent every ``period`` s from ``first`` on and read at each row, at steps of 50 ms.

    And how far the command is ahead of the mean of what was in force, on average, s.
    """
    time = 0.02 * np.arange(1500)
    sent = lambda moment: RAMP * (first + period * np.floor((moment - first) / period + 1e-9))  # noqa: E731
    log = log_at(time)
    write_log(Trajectory(time, log.state, sent(time)[:, None], log.inputs, LAYOUTS), folder / "log.csv")
    made = read_log(folder / "log.csv", layouts=LAYOUTS, dt=0.05)
    parts = 1000
    moments = made.time[:, None] + 0.05 * (np.arange(parts) + 0.5) / parts
    return made, float(np.mean(made.action[:-1, 0] - sent(moments).mean(1)[:-1])) / RAMP


@pytest.mark.parametrize("period", [0.047, 0.0613])
def test_a_command_of_a_slower_clock_is_as_often_early_as_late(tmp_path: Path, period: float) -> None:
    """Read at the rows alone, it would be late by half of the 20 ms between them."""
    assert abs(polled(tmp_path, period, -0.003)[1]) < 0.001


@pytest.mark.parametrize("period", [0.04, 0.1])
def test_a_command_that_is_sent_with_every_nth_row_begins_there(tmp_path: Path, period: float) -> None:
    assert abs(polled(tmp_path, period, 0.0)[1]) < 1e-6


def test_unknown_columns_hold_their_last_value(tmp_path: Path) -> None:
    time = jittered(4)
    log = reread(tmp_path, time, 0.02)
    expected = [sum(time <= stamp + 1e-12) - 1 for stamp in log.time]
    assert np.array_equal(log.extra["counter"], expected)


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_regular_stamps_stay_untouched(tmp_path: Path, noise: float) -> None:
    time = 0.02 * np.arange(100) + np.random.default_rng(0).uniform(-noise, noise, 100)
    log = reread(tmp_path, time, 0.02)
    assert np.array_equal(log.time, time)
    assert np.array_equal(log.state, log_at(time).state)
    assert log.notes == ()


def test_without_a_step_rows_stay_as_recorded(tmp_path: Path) -> None:
    time = np.array([0.0, 0.02, 0.9, 0.91])
    assert np.array_equal(reread(tmp_path, time, None).time, time)


def test_a_fast_log_is_sampled_down(tmp_path: Path) -> None:
    time = 0.002 * np.arange(501)
    log = reread(tmp_path, time, 0.02)
    assert len(log) == 51
    assert_on_the_motion(log)
    held = np.searchsorted(time, log.time + 0.01 - 1e-9)
    assert np.all(np.abs(log.action[:, 0] - held) <= 1)


def test_a_reversed_quaternion_sign_is_no_turn(tmp_path: Path) -> None:
    time = jittered(5)
    flipped = log_at(time)
    flipped.state[::3, 1:5] *= -1
    write_log(flipped, tmp_path / "log.csv")
    log = read_log(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    assert_on_the_motion(log)
    assert np.all(np.sum(log.state[1:, 1:5] * log.state[:-1, 1:5], axis=1) > 0.9)


def test_one_or_two_missing_rows_are_bridged(tmp_path: Path) -> None:
    time = np.delete(0.02 * np.arange(100), [30, 60, 61])
    log = reread(tmp_path, time, 0.02)
    assert len(log) == 100
    assert_on_the_motion(log)


def test_stamps_in_another_unit_are_refused(tmp_path: Path) -> None:
    """Milliseconds taken for seconds: nearly every row would be made up."""
    write_log(log_at(20.0 * np.arange(100)), tmp_path / "log.csv")
    for read in (read_log, read_logs):
        with pytest.raises(DataError, match=r"log\.csv, column 'time': .*unit of the stamps right.*found 20 s"):
            read(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    # Seconds taken for milliseconds: a flight of 40 s would shrink to two rows.
    write_log(log_at(2e-5 * np.arange(2000)), tmp_path / "log.csv")
    with pytest.raises(DataError, match=r"column 'time': .*500 rows in one .*found rows 2e-05 s apart"):
        read_logs(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)


def test_a_gap_is_refused_with_its_place_or_split(tmp_path: Path) -> None:
    time = np.delete(0.02 * np.arange(100), [*range(30, 34), *range(60, 70)])
    write_log(log_at(time), tmp_path / "log.csv")
    with pytest.raises(
        DataError, match=r"log\.csv, row 32, column 'time'.*a gap of 0\.1 s before this row, at 0\.68 s"
    ):
        read_log(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    pieces = read_logs(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    assert [piece.name for piece in pieces] == ["log#1", "log#2", "log#3"]
    assert np.array_equal(np.concatenate([piece.time for piece in pieces]), time)
    assert all(np.diff(piece.time).max() < GAP_INTERVALS * 0.02 for piece in pieces)
    assert "rows 32 to 57" in " ".join(pieces[1].notes)
    assert pieces.transitions().state.shape[0] == len(time) - 3


@pytest.mark.parametrize("dt", [0.02, None])
def test_runs_whose_clock_begins_anew_in_one_file_are_logs_of_their_own(tmp_path: Path, dt: float | None) -> None:
    """As an id column beside them tells; each is what its rows are in a file of their own."""
    runs = [log_at(0.02 * np.arange(first, first + rows)) for first, rows in ((0, 100), (0, 60), (3, 80))]
    texts = []
    for number, run in enumerate(runs):
        write_log(run, tmp_path / f"run{number}.csv")
        texts.append((tmp_path / f"run{number}.csv").read_text().splitlines(keepends=True))
    together = tmp_path / "all.csv"
    together.write_text("".join([texts[0][0], *(line for text in texts for line in text[1:])]))
    pieces = read_logs(together, layouts=LAYOUTS, dt=dt)
    assert [piece.name for piece in pieces] == ["all#1", "all#2", "all#3"]
    for piece, run in zip(pieces, runs, strict=True):
        np.testing.assert_allclose(np.diff(piece.time), 0.02)
        np.testing.assert_array_equal(piece.state, run.state)
    with pytest.raises(DataError, match=r"row 102, .*a gap"):
        read_log(together, layouts=LAYOUTS, dt=0.02)


def test_a_row_alone_between_gaps_is_left_out(tmp_path: Path) -> None:
    time = np.array([0.0, 0.02, 0.5, 1.0, 1.02, 1.04])
    write_log(log_at(time), tmp_path / "log.csv")
    assert [len(piece) for piece in read_logs(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)] == [2, 3]


def test_derived_velocities_do_not_reach_across_a_gap(tmp_path: Path) -> None:
    time = np.concatenate([0.02 * np.arange(20), 1.0 + 0.02 * np.arange(20)])
    x = np.where(time < 0.9, time, 50.0 - time)
    rows = "\n".join(f"{t!r},{a!r}" for t, a in zip(time.tolist(), x.tolist(), strict=True))
    (tmp_path / "log.csv").write_text(f"t,p\n{rows}\n")
    (tmp_path / "spec.toml").write_text('derive = ["velocity"]\n[time]\ndt = 0.02\ncolumn = "t"\n[columns]\nx = "p"\n')
    first, second = read_logs(tmp_path / "log.csv", tmp_path / "spec.toml")
    assert np.allclose(first.column("vx"), 1.0)
    assert np.allclose(second.column("vx"), -1.0)


@pytest.mark.parametrize("clock", [0.984, 1.008])
def test_rows_of_another_clock_are_brought_to_the_models_step(tmp_path: Path, clock: float) -> None:
    """Taken as they are, what moves at 3 m/s would seem to move 1.6 % slower or 0.8 % faster."""
    log = reread(tmp_path, 0.02 * clock * np.arange(200), 0.02)
    assert np.allclose(np.diff(log.time), 0.02)
    assert_on_the_motion(log)
    sent = log.action[:-1, 0]  # rows of the file are counted from 1, and held until the next
    assert np.mean(sent - log.time[:-1] / (0.02 * clock)) == pytest.approx(1.0 + 0.5 * (1.0 / clock - 1.0), abs=0.01)


@pytest.mark.parametrize("hertz", [20, 25, 50, 100, 125])
def test_stamps_in_whole_milliseconds_of_the_models_clock_stay_untouched(tmp_path: Path, hertz: int) -> None:
    time = np.round(1.234567 + np.arange(300) / hertz, 3)
    log = reread(tmp_path, time, 1.0 / hertz)
    assert np.array_equal(log.time, time)
    assert log.dt == pytest.approx(1.0 / hertz, rel=1e-4)


def test_a_log_from_arrays_is_cut_and_resampled_as_a_file_is(tmp_path: Path) -> None:
    kept = np.setdiff1d(np.arange(200), [20, 51, 52, 100, *range(130, 140)])
    log = log_at(0.02 * kept)
    write_log(log, tmp_path / "log.csv")
    read = read_logs(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    made = equal_steps(log, 0.02)
    assert len(made) == len(read) == 2
    for one, other in zip(made, read, strict=True):
        assert one.name == other.name
        for group in ("time", "state", "action", "inputs"):
            assert np.allclose(getattr(one, group), getattr(other, group), atol=1e-9)
        assert_on_the_motion(one)
    regular = log_at(0.02 * np.arange(50))
    assert equal_steps(regular, 0.02) == [regular]
    fast = log_at(0.01 * np.arange(50))
    assert equal_steps(fast, 0.02) == [fast]


@pytest.mark.parametrize(("chatters", "lengths"), [(True, [90, 109]), (False, [200])])
def test_a_lost_row_of_commands_that_chatter_is_a_gap(tmp_path: Path, *, chatters: bool, lengths: list[int]) -> None:
    """What such a controller sent in it nobody knows, and a joint that it moves does not wait."""
    log = log_at(np.delete(0.02 * np.arange(200), 90))
    if chatters:
        log.action[:, 0] = np.where(np.arange(len(log)) % 2, 1.0, -1.0)
    write_log(log, tmp_path / "log.csv")
    read = read_logs(tmp_path / "log.csv", layouts=LAYOUTS, dt=0.02)
    assert [len(part) for part in read] == lengths
