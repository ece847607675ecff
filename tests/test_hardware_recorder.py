"""One run, one file: what was asked and sent, readable at once, and after the process was killed."""

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from hardware.arrow_stream import ArrowStream
from hardware.interfaces import Verdict
from hardware.pilot import FlightPilot
from hardware.plant import HardwarePlant
from hardware.provenance import hash_of, revision
from hardware.recorder import Recorder, task_of
from hardware.row import Row
from sym2real.errors import DataError
from sym2real.logs import read_log
from sym2real.robots import CRAZYFLIE
from tests.forked import in_fork
from tests.hardware_link import SimulatedLink, TestClock

PLACE = np.array([0.0, 0.0, 0.5, 1.0, *[0.0] * 9])


def fly(recorder: Recorder, steps: int = 60) -> list[Row]:
    """A start, a task of so many steps, a landing; the rows that were recorded."""
    clock, rows = TestClock(), []

    def record(row: Row) -> None:
        rows.append(row)
        recorder.add(row)

    link = SimulatedLink(clock)
    with HardwarePlant(link, FlightPilot(CRAZYFLIE), clock=clock, record=record, guard=False) as plant:
        plant.reset(PLACE)
        for _ in range(steps):
            plant.step(CRAZYFLIE.rest)
        plant.land()
    return rows


LOADED = """
import sys, time
from pathlib import Path
from tests.test_hardware_recorder import CRAZYFLIE, Recorder, fly
path = Path(sys.argv[1])
with Recorder(path.with_name("before.parquet"), CRAZYFLIE, {}) as recorder:
    fly(recorder)  # what the simulated link loads
with Recorder(path, CRAZYFLIE, {}) as recorder:
    before = set(sys.modules)
    fly(recorder)
    while not path.with_suffix(".arrow").exists() or path.with_suffix(".arrow").stat().st_size < 10000:
        time.sleep(0.01)
    print(sorted(set(sys.modules) - before))
"""


def test_nothing_is_loaded_in_flight(tmp_path: Path) -> None:
    """A library that is loaded with the first row holds Python still at take-off, for part of a second."""
    command = [sys.executable, "-c", LOADED, str(tmp_path / "flight.parquet")]
    told = subprocess.run(
        command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=True, timeout=120
    )
    assert told.stdout.strip() == "[]"


def test_a_run_reads_back_as_it_was_flown(tmp_path: Path) -> None:
    path = tmp_path / "flight.parquet"
    with Recorder(path, CRAZYFLIE, {"thrust_map": {"name": "x"}}) as recorder:
        rows = fly(recorder)
    log = read_log(path, layouts=CRAZYFLIE.layouts)
    assert len(log) == len(rows)
    assert (log.state == np.array([row.reading.state for row in rows])).all()
    assert (log.action == np.array([row.sent for row in rows])).all()
    asked = np.array([row.asked for row in rows])
    assert np.array_equal(log.extra["asked_thrust"], asked[:, 0], equal_nan=True)
    assert log.action[5, 0] == pytest.approx(0.99 * log.extra["asked_thrust"][5])
    assert (log.extra["clock"] == [row.reading.time for row in rows]).all()
    assert (log.extra["vbat"] == 4.0).all()
    assert log.time[0] == 0.0
    about = yaml.safe_load(path.with_suffix(".yaml").read_text())
    assert about["thrust_map"] == {"name": "x"}
    assert (about["rows"], about["robot"]) == (len(rows), "crazyflie")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["flight.parquet", "flight.yaml"]


def test_the_task_is_cut_out_with_its_true_stamps(tmp_path: Path) -> None:
    path = tmp_path / "flight.parquet"
    with Recorder(path, CRAZYFLIE, {}) as recorder:
        rows = fly(recorder)
    task = task_of(path, CRAZYFLIE)
    flown = [row for row in rows if row.stage == "task" and row.command.verdict is Verdict.GO]
    assert len(task) == len(flown) == 60
    assert task.time == pytest.approx([row.reading.time - flown[0].reading.time for row in flown])
    assert (task.action == np.array([row.sent for row in flown])).all()


def test_a_task_with_missed_periods_is_still_cut_out(tmp_path: Path) -> None:
    """A gap that `read_log` would refuse, and a moment without an attitude, which is no row."""
    recorder = Recorder(tmp_path / "flight.parquet", CRAZYFLIE, {})
    rows = [row for row in fly(recorder) if row.stage == "task"]
    recorder.close()
    late = replace(rows[9], reading=replace(rows[9].reading, time=rows[9].reading.time + 9.0))
    blind = replace(late, reading=replace(late.reading, time=late.reading.time + 1.0, state=np.full(13, np.nan)))
    with Recorder(tmp_path / "gap.parquet", CRAZYFLIE, {}) as again:
        for row in (*rows[:9], late, blind):
            again.add(row)
    task = task_of(tmp_path / "gap.parquet", CRAZYFLIE)
    assert len(task) == 10
    assert task.time[9] - task.time[8] == pytest.approx(9.02)


def test_a_stream_is_readable_while_it_grows_and_where_it_is_cut_off(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "flight.parquet", CRAZYFLIE, {})
    rows = fly(recorder)
    recorder._rows.put(None)
    recorder._thread.join()  # the process ends here: nobody closes the recorder
    assert len(read_log(recorder.growing)) == len(rows)
    content = recorder.growing.read_bytes()
    cut = tmp_path / "cut.arrow"
    cut.write_bytes(content[: len(content) * 2 // 3])
    part = read_log(cut)
    assert 0 < len(part) < len(rows)
    assert (part.state == np.array([row.reading.state for row in rows[: len(part)]])).all()
    cut.write_bytes(content[:100])
    with pytest.raises(DataError, match="Arrow stream"):
        read_log(cut)


def test_a_killed_process_leaves_its_rows(tmp_path: Path) -> None:
    """kill -9 as soon as the recorder calls the rows written: all of them are there."""
    path = tmp_path / "flight.parquet"

    def killed() -> None:
        recorder = Recorder(path, CRAZYFLIE, {})
        rows = fly(recorder)
        while recorder.written < len(rows):
            time.sleep(0.01)
        print(len(rows), flush=True)
        os.kill(os.getpid(), signal.SIGKILL)

    ran = in_fork(killed, tmp_path)
    assert ran.status == -signal.SIGKILL
    assert len(read_log(path.with_suffix(".arrow"), layouts=CRAZYFLIE.layouts)) == int(ran.out)
    assert "killed" in yaml.safe_load(path.with_suffix(".yaml").read_text())["ended"]


def test_a_full_disk_is_told_at_once_and_the_flight_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """It flew to the end without a word, and its YAML file said that it still ran, or was killed."""
    append, path = ArrowStream.append, tmp_path / "flight.parquet"

    def refuse(stream: ArrowStream, rows: Sequence[Mapping[str, float | str]]) -> None:
        if recorder.written:
            raise OSError(errno.ENOSPC, "none")
        append(stream, rows)

    monkeypatch.setattr(ArrowStream, "append", refuse)
    with pytest.raises(DataError, match="No space left"), Recorder(path, CRAZYFLIE, {}) as recorder:
        rows = fly(recorder)
        recorder._thread.join()
        assert caplog.text.count("No space left") == 1
        assert rows[-1].command.reason == "the task is over"
    about = yaml.safe_load(path.with_suffix(".yaml").read_text())
    assert (about["ended"], about["failed"]) == ("the task is over", "No space left on device")
    assert len(read_log(recorder.growing)) == about["rows"] == recorder.written > 0


def test_no_flight_is_written_over_another(tmp_path: Path) -> None:
    (tmp_path / "flight.arrow").write_bytes(b"left behind by a killed run")
    with pytest.raises(DataError, match="written over"):
        Recorder(tmp_path / "flight.parquet", CRAZYFLIE, {})
    with pytest.raises(DataError, match="ends in"):
        Recorder(tmp_path / "flight.txt", CRAZYFLIE, {})


def test_a_run_without_a_row_leaves_its_description(tmp_path: Path) -> None:
    with Recorder(tmp_path / "flight.parquet", CRAZYFLIE, {}):
        pass
    assert [file.name for file in tmp_path.iterdir()] == ["flight.yaml"]


def test_the_hash_is_of_the_content(tmp_path: Path) -> None:
    (tmp_path / "equations.json").write_text("{}")
    before = hash_of(tmp_path)
    (tmp_path / "equations.json").write_text("{ }")
    assert before != hash_of(tmp_path)
    assert revision()
