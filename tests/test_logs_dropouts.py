"""Rows that a sensor or a link left empty: short holes are bridged, long ones cut the log, and both are said."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from log_files import saved

from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.sanity import check
from sym2real.errors import DataError
from sym2real.experiments.measured import step_of_logs
from sym2real.logs import SPECS, LogSpec, inspect_logs, read_log, read_logs
from sym2real.robots import quadrotor

NAME = "crazyflie_battery_drag"
POSE = ["px", "py", "pz", "qw", "qx", "qy", "qz"]


def with_holes(folder: Path, **holes: slice) -> Path:
    """The real flight without the pose in some rows."""
    flight = pd.read_csv(example_flight())
    for rows in holes.values():
        flight.loc[flight.index[rows], POSE] = np.nan
    return saved(folder, flight)


def whole() -> Dataset:
    return read_logs(example_flight(), NAME)


def test_a_long_hole_cuts_the_log_and_a_short_one_is_bridged(tmp_path: Path) -> None:
    path = with_holes(tmp_path, short=slice(100, 102), long=slice(300, 331))
    first, second = read_logs(path, NAME)
    assert (first.name, second.name) == ("log#1", "log#2")
    assert (len(first), len(second)) == (300, 829 - 331)
    note = "33 of 829 rows left out, for want of numbers in px, py, pz, qw, qx, qy, qz: rows 102 to 103, 302 to 332"
    for piece in (first, second):
        assert note in piece.notes
    assert "cut at a gap of the stamps: rows 2 to 301" in first.notes
    assert "cut at a gap of the stamps: rows 333 to 830" in second.notes
    (log,) = whole()
    np.testing.assert_allclose(second.time, log.time[331:], atol=1e-9)
    np.testing.assert_allclose(second.state, log.state[331:], atol=1e-9)
    # Elsewhere it is what was measured; in the short hole it is on the line between what was measured on both sides.
    known, there = log.column("x")[:300], np.delete(np.arange(300), [100, 101])
    on_lines = np.interp(first.time, log.time[there], known[there])
    np.testing.assert_allclose(first.column("x"), on_lines, atol=1e-12)
    outside = np.delete(np.arange(300), np.arange(99, 103))
    np.testing.assert_allclose(first.column("x")[outside], np.interp(first.time, log.time[:300], known)[outside])


def test_a_log_in_pieces_is_no_single_log(tmp_path: Path) -> None:
    path = with_holes(tmp_path, long=slice(300, 331))
    with pytest.raises(DataError, match=r"row 333.*a gap of 0\.64 s"):
        read_log(path, NAME)


def test_rows_that_were_written_twice_count_once(tmp_path: Path) -> None:
    flight = pd.read_csv(example_flight())
    again = flight.loc[sorted([*flight.index, 40, 41, 41, 500])]
    path = saved(tmp_path, again)
    log, (known,) = read_log(path, NAME), whole()
    np.testing.assert_array_equal(log.state, known.state)
    note = "4 of 833 rows left out, which repeat the one before, stamp and all: rows 43, 45 to 46, 506"
    assert note in log.notes
    found = {row.meaning: row.evidence for row in inspect_logs(path).rows}
    assert note in found["rows left out"]


def test_of_rows_that_differ_under_one_stamp_none_is_chosen(tmp_path: Path) -> None:
    flight = pd.read_csv(example_flight())
    again = flight.loc[sorted([*flight.index, 40])].reset_index(drop=True)
    again.loc[41, "px"] += 0.01
    with pytest.raises(DataError, match=r"row 43, column 't'.*with other values.*keep one of each stamp"):
        read_log(saved(tmp_path, again), NAME)


def test_without_stamps_rows_keep_their_time(tmp_path: Path) -> None:
    time = np.arange(20.0)
    x = np.where((time > 4) & (time < 12), np.nan, 3 * time)
    file = saved(tmp_path, {"x": x, "y": time})
    spec = LogSpec.parse('[time]\nrate = 50\n[columns]\nx = "x"\ny = "y"')
    first, second = read_logs(file, spec)
    np.testing.assert_allclose(first.time, 0.02 * np.arange(5))
    np.testing.assert_allclose(second.time, 0.02 * np.arange(12, 20))
    np.testing.assert_allclose(second.column("x"), 150 * second.time)


def test_a_slower_column_is_held_where_the_specification_says_so(tmp_path: Path) -> None:
    flight = pd.read_csv(example_flight())
    flight.loc[np.arange(len(flight)) % 5 != 3, "vbat"] = np.nan
    saved(tmp_path, flight)
    with pytest.raises(DataError, match=r"column 'vbat'.*hold = \[\"vbat\"\].*80 % of the rows"):
        read_logs(tmp_path / "log.csv", NAME)
    spec = LogSpec.parse('hold = ["vbat"]\n' + SPECS[NAME].toml())
    assert LogSpec.parse(spec.toml()) == spec
    (log,) = read_logs(tmp_path / "log.csv", spec)
    (known,) = whole()
    assert "3 of 829 rows left out" in " ".join(log.notes)
    np.testing.assert_array_equal(log.state[:, :3], known.state[3:, :3])
    np.testing.assert_array_equal(log.column("vbat")[:5], np.full(5, known.column("vbat")[3]))
    proposed = inspect_logs(tmp_path / "log.csv")
    assert proposed.spec.hold == ("vbat",)
    assert LogSpec.parse(proposed.toml()) == proposed.spec


def driven(rows: int = 600) -> pd.DataFrame:
    """Rows of 20 ms of a car on a curve, with noise."""
    rng, time = np.random.default_rng(0), 0.02 * np.arange(rows)
    yaw = 0.5 * np.sin(time)
    course = {"x": np.cumsum(0.03 * np.cos(yaw)), "y": np.cumsum(0.03 * np.sin(yaw)), "yaw": yaw}
    noisy = {name: values + 0.003 * rng.standard_normal(rows) for name, values in course.items()}
    return pd.DataFrame({"t": time, **noisy, "steer": 0.2 * np.cos(time), "speed": 1.5 + 0.0 * time})


@pytest.mark.parametrize("empty", [False, True])
def test_the_rows_are_those_of_new_positions_and_commands_go_on_between_them(tmp_path: Path, empty: bool) -> None:
    """As of a satellite receiver in the rows of a faster controller, whether cells are empty or hold the last one."""
    drive, between = driven(), np.arange(600) % 10 != 0
    drive.loc[between, ["x", "y"]] = np.nan
    file = saved(tmp_path, drive if empty else drive.ffill())
    proposed = inspect_logs(file)
    assert proposed.spec.hold == ()
    assert proposed.spec.time.dt == 0.02
    spec = LogSpec.parse(proposed.toml())
    (log,) = read_logs(file, spec, dt=0.02)
    assert log.dt == pytest.approx(0.2)
    np.testing.assert_allclose(log.state[:, :2], driven()[["x", "y"]].to_numpy()[~between])
    np.testing.assert_allclose(log.action[:, 0], driven()["steer"].to_numpy().reshape(60, 10).mean(1))
    assert any("540 of 600 rows left out, for want of numbers in x, y" in note for note in log.notes)
    assert any("x, y are new in every 10 rows" in note for note in log.notes) is not empty
    assert step_of_logs([file], spec) == 0.02


def test_rows_of_which_every_second_repeats_all_that_is_measured_are_those_of_a_slower_sensor(tmp_path: Path) -> None:
    """Commands go on in between; where a heading does as well, every second row of positions is left to the checks."""
    drive, second = driven(), np.arange(600) % 2 == 1
    for columns, rows in ((["x", "y", "yaw"], 300), (["x", "y"], 600)):
        held = driven()
        held.loc[second, columns] = np.nan
        (tmp_path / str(rows)).mkdir()
        file = saved(tmp_path / str(rows), held.ffill())
        (log,) = read_logs(file, LogSpec.parse(inspect_logs(file).toml()))
        assert len(log) == rows
        np.testing.assert_allclose(log.state[:: rows // 300, :2], drive[["x", "y"]].to_numpy()[~second])


def test_a_position_that_repeats_now_and_then_or_stands_still_is_no_slower_sensor(tmp_path: Path) -> None:
    drive, rng = driven(), np.random.default_rng(1)
    lost = rng.random(600) < 0.3
    drive.loc[lost, ["x", "y"]] = np.nan
    still = driven()
    still.loc[100:500, ["x", "y"]] = still.loc[100, ["x", "y"]].to_numpy()
    coarse = driven().round({"x": 2, "y": 2})
    for name, log in (("repeats", drive.bfill().ffill()), ("still", still), ("coarse", coarse)):
        (tmp_path / name).mkdir()
        file = saved(tmp_path / name, log)
        assert sum(map(len, read_logs(file, LogSpec.parse(inspect_logs(file).toml())))) == 600


def test_a_command_with_rows_of_its_own_is_no_later_than_in_a_recording(tmp_path: Path) -> None:
    """A table of several topics, each message a row: a row has what is in force halfway to the next, as in a bag."""
    poses = pd.DataFrame({"t": 0.02 * np.arange(200), "x": np.arange(200.0), "y": 0.0})
    sent = pd.DataFrame({"t": [0.0, 0.042, 0.0799, 0.131], "steer": [0.1, 0.2, 0.3, 0.4]})
    file = tmp_path / "log.csv"
    pd.concat([sent, poses]).sort_values("t", kind="stable").to_csv(file, index=False)
    named = "\n".join(f'{name} = "{name}"' for name in ("x", "y", "steer"))
    (log,) = read_logs(file, LogSpec.parse(f'hold = ["steer"]\n[time]\ncolumn = "t"\n[columns]\n{named}'))
    np.testing.assert_array_equal(log.state[:, 0], np.arange(200.0))
    first = [int(np.flatnonzero(log.action[:, 0] == value)[0]) for value in (0.1, 0.2, 0.3, 0.4)]
    assert first == [0, 2, 4, 7]  # rows begin at 0, 40, 80 and 140 ms


@pytest.mark.parametrize("period", [0.047, 0.0613])
def test_a_command_with_rows_of_its_own_is_as_often_early_as_late(tmp_path: Path, period: float) -> None:
    poses = pd.DataFrame({"t": 0.02 * np.arange(1500), "x": np.arange(1500.0), "y": 0.0})
    moments = np.arange(0.0, 29.9, period)
    sent = pd.DataFrame({"t": moments, "steer": 0.01 * np.arange(len(moments))})
    file = tmp_path / "log.csv"
    pd.concat([sent, poses]).sort_values("t", kind="stable").to_csv(file, index=False)
    named = "\n".join(f'{name} = "{name}"' for name in ("x", "y", "steer"))
    (log,) = read_logs(file, LogSpec.parse(f'hold = ["steer"]\n[time]\ncolumn = "t"\n[columns]\n{named}'), dt=0.05)
    exact = (log.time[:, None] + 0.05 * (np.arange(500) + 0.5) / 500) // period * 0.01
    late = (exact.mean(1) - log.action[:, 0])[5:-20] * period / 0.01
    assert abs(late.mean()) < 0.001


@pytest.mark.parametrize("name", ["gps_time", "thrust_cmd"])
def test_a_proposal_holds_only_what_it_names(tmp_path: Path, name: str) -> None:
    flight = pd.read_csv(example_flight())
    slow = 30000.0 + np.arange(len(flight))
    flight[name] = np.where(np.arange(len(flight)) % 5 == 3, slow, np.nan)
    proposed = inspect_logs(saved(tmp_path, flight))
    assert proposed.spec.hold == ()
    assert LogSpec.parse(proposed.toml()) == proposed.spec
    assert proposed.spec.time.column == "t"


def test_what_is_empty_throughout_is_named(tmp_path: Path) -> None:
    file = saved(tmp_path, pd.read_csv(example_flight()).assign(vbat=np.nan))
    for read in (inspect_logs, lambda path: read_logs(path, NAME)):
        with pytest.raises(DataError, match=r"a row with numbers in all of vbat, found none"):
            read(file)


def test_an_inspection_wants_rows_with_numbers(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"at least 20 rows with numbers to look into, found 3"):
        inspect_logs(with_holes(tmp_path, died=slice(3, None)))


def test_columns_that_nobody_asks_for_may_be_empty(tmp_path: Path) -> None:
    (log,) = read_logs(saved(tmp_path, pd.read_csv(example_flight()).assign(sonar=np.nan)), NAME)
    assert len(log) == 829


def test_inspection_and_diagnosis_say_what_is_missing(tmp_path: Path) -> None:
    path = with_holes(tmp_path, long=slice(300, 331))
    found = inspect_logs(path)
    meanings = {row.meaning: row.evidence for row in found.rows}
    assert "31 of 829 rows left out" in meanings["rows left out"]
    assert any(meaning.startswith("gap") and "0.64 s" in said for meaning, said in meanings.items())
    model = quadrotor(1.0, interface="motors", attitude="measured")
    data = read_logs(path, NAME, model.layouts, model.dt)
    notes = " ".join(check(model, data).notes)
    assert "log#1: 31 of 829 rows left out" in notes
    assert "cut at a gap of the stamps: log#1 rows 2 to 301, log#2 rows 333 to 830" in notes


def test_what_to_hold_must_be_a_column() -> None:
    with pytest.raises(DataError, match="in hold a column that exists"):
        LogSpec.parse('hold = ["vbatt"]\n' + SPECS[NAME].toml())
