"""Long and fast logs: the same answers from a bounded number of rows, and it is said which."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from long_flight import flight, save

from sym2real.logs import Inspection, inspect_logs, read_log
from sym2real.logs.evidence import LENGTH, RATE, STRETCHES, stretches, words

MOST = STRETCHES * LENGTH


def looked_at(inspection: Inspection) -> str:
    """What the inspection says of rows that it left out."""
    return "".join(row.evidence for row in inspection.rows if row.meaning == "not every row is looked at")


def test_a_log_that_is_short_enough_is_looked_at_whole() -> None:
    time = np.arange(MOST) / RATE
    (whole,) = stretches([time])
    np.testing.assert_array_equal(time[whole.rows], time)
    assert words([time], [whole]) == ""


def test_evidence_is_bounded_and_reaches_from_the_first_row_to_the_last() -> None:
    for hertz, rows in ((100.0, 10**6), (1000.0, 10**6), (50.0, MOST + 1)):
        time = np.arange(rows) / hertz
        found = stretches([time])
        used = np.concatenate([np.arange(rows)[one.rows] for one in found])
        assert len(used) == MOST
        assert used[0] == 0
        assert used[-1] >= rows - round(hertz / RATE) - 1
        assert all((np.diff(time[one.rows]) < 1.01 * max(1.0 / RATE, 1.0 / hertz)).all() for one in found)
        assert words([time], found).startswith(f"{MOST} of {rows} rows")


def test_two_logs_of_different_length_keep_their_own_rows() -> None:
    times = [np.arange(rows) / RATE for rows in (200, 2 * MOST)]
    found = stretches(times)
    assert [one.log for one in found] == [0, *[1] * STRETCHES]
    assert found[0].rows == slice(0, 200, 1)
    assert f"{200 + MOST} of {200 + 2 * MOST}" in words(times, found)


def test_a_long_log_is_read_as_its_first_minutes_are(tmp_path: Path) -> None:
    columns = flight(2 * MOST, RATE)
    whole = inspect_logs(save(columns, tmp_path / "long.parquet"))
    part = inspect_logs(save({name: v[:MOST] for name, v in columns.items()}, tmp_path / "part.parquet"))
    assert whole.spec == part.spec
    assert looked_at(part) == ""
    assert f"{MOST} of {2 * MOST} rows ({STRETCHES} stretches" in looked_at(whole)


def test_what_happens_late_in_a_long_log_is_seen(tmp_path: Path) -> None:
    """Most of the recording on the ground, rates in degrees a second: the unit is still found."""
    columns = flight(3 * MOST, RATE)
    still = {name: np.r_[np.full(2 * MOST, v[0]), v[2 * MOST :]] for name, v in columns.items() if name != "timestamp"}
    turned = {name: np.degrees(v) if name.startswith("gyro") else v for name, v in still.items()}
    found = inspect_logs(save({"timestamp": columns["timestamp"], **turned}, tmp_path / "late.parquet"))
    assert found.spec.columns["wx"].unit == found.spec.columns["wz"].unit == "deg/s"


def test_a_gap_and_an_empty_cell_outside_the_stretches_are_told(tmp_path: Path) -> None:
    columns = flight(3 * MOST, RATE)
    firsts = [one.rows.stop for one in stretches([columns["timestamp"]])]
    place = firsts[0] + 100  # between the first stretch and the second
    columns["timestamp"][place:] += 5.0
    columns["vel_x"][place + 50] = np.nan
    rows = inspect_logs(save(columns, tmp_path / "gap.parquet")).rows
    assert any(row.meaning.startswith("gap") and "5.01 s" in row.evidence for row in rows)
    assert any(row.meaning == "rows left out" and "vel_x" in row.evidence for row in rows)


def test_a_fast_log_is_read_at_the_step_of_a_model(tmp_path: Path) -> None:
    columns = flight(50_000, 1000.0)
    path = save(columns, tmp_path / "fast.parquet")
    found = inspect_logs(path)
    assert "every 10th row" in looked_at(found)
    log = read_log(path, found.spec, dt=0.02)
    assert len(log) == 2500
    np.testing.assert_allclose(log.column("x"), columns["pos_x"][::20], atol=1e-9)
