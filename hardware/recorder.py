"""One run, one file: every control period as a row, written while it is flown.

``flight.arrow`` grows by a batch twenty times a second and becomes ``flight.parquet`` when the run ends. A killed
process loses less than a tenth of a second. Beside it ``flight.yaml`` says what was flown.
"""

import json
import logging
import math
import queue
import threading
import time
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from hardware import arrow_stream
from hardware.row import Row
from sym2real.errors import DataError, MissingDependencyError, reason
from sym2real.files import make_folder, write_text
from sym2real.logs.table import read_table
from sym2real.robots import Robot
from sym2real.trajectory import Trajectory

LOGGER = logging.getLogger(__name__)
BATCH = 0.05  # s between two writes
STAGES = {"way to the start": 0.0, "task": 1.0, "landing": 2.0}
TEXTS = ("phase", "reason", "flags")
NONE = "-"  # an empty cell would be a missing number to a reader
Cells = dict[str, float | str]


class Recorder:
    """Writes what a plant reports from a thread of its own: a slow disk does not hold up a flight.

    Args:
        path: new file, .parquet; an Arrow stream beside it until the end.
        robot: whose columns they are.
        about: what the YAML file says besides: thrust map, limits, model, revision.

    Raises:
        DataError: for another ending, a file that is there already, or no place to write to.
        MissingDependencyError: without PyYAML.
    """

    def __init__(self, path: str | Path, robot: Robot, about: Mapping[str, Any]) -> None:
        self.path, self._robot, self._about = Path(path), robot, dict(about)
        if self.path.suffix != ".parquet":
            raise DataError(self.path, "a file name that ends in .parquet", repr(self.path.suffix))
        self.growing = self.path.with_suffix(".arrow")
        for file in (self.path, self.growing):
            if file.exists():
                raise DataError(file, "a name that is free: no flight is written over another", "a file")
        make_folder(self.path.parent)
        arrow_stream.prepare()  # not in flight
        self._rows: queue.SimpleQueue[Row | None] = queue.SimpleQueue()
        self._failure: Exception | None = None
        self._written, self._first, self._reason = 0, math.nan, ""
        self._describe({"started": time.strftime("%Y-%m-%dT%H:%M:%S%z"), "ended": "still running, or killed"})
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    @property
    def written(self) -> int:
        """Rows that a kill cannot take away any more."""
        return self._written

    def add(self, row: Row) -> None:
        """Take a row; it never waits."""
        self._reason = row.command.reason
        self._rows.put(row)

    def close(self, ended: str = "") -> None:
        """Write what is left; the stream becomes Parquet, the YAML file says how the run ended.

        Raises:
            DataError: when rows could not be written.
        """
        self._rows.put(None)
        self._thread.join()
        failed = {} if self._failure is None else {"failed": reason(self._failure)}
        try:  # before what a full disk may refuse
            self._describe({"ended": ended or self._reason or "closed in flight", "rows": self._written, **failed})
        finally:
            if self._failure is not None:
                raise DataError(self.growing, "a file that can be written", failed["failed"]) from self._failure
        if self._written:
            arrow_stream.to_parquet(self.growing, self.path)
            self.growing.unlink()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close("" if kind is None else f"{kind.__name__}: {error}")

    def _run(self) -> None:
        first = self._rows.get()
        if first is None:
            return
        self._first = first.reading.time
        try:
            with closing(self._file(self._cells(first))) as file:
                self._append_all(file, first)
        except Exception as error:
            self._failure = error
            LOGGER.error("%s: nothing more is recorded, the flight goes on: %s", self.growing, reason(error))

    def _append_all(self, file: arrow_stream.ArrowStream, first: Row) -> None:
        waiting: list[Row | None] = [first]
        while True:
            rows = [self._cells(row) for row in waiting if row is not None]
            file.append(rows)
            self._written += len(rows)
            if None in waiting:
                return
            waiting = [self._rows.get()]
            if waiting[0] is not None:
                time.sleep(BATCH)
            while not self._rows.empty():
                waiting.append(self._rows.get())

    def _file(self, cells: Cells) -> arrow_stream.ArrowStream:
        metadata = {"layouts": json.dumps(self._robot.layouts.to_dict()), "name": self.path.stem, "notes": "[]"}
        return arrow_stream.ArrowStream(self.growing, {name: name in TEXTS for name in cells}, metadata)

    def _cells(self, row: Row) -> Cells:
        reading, layouts = row.reading, self._robot.layouts
        cells: Cells = {"time": reading.time - self._first}
        cells |= dict(zip(layouts.state, reading.state.tolist(), strict=True))
        cells |= dict(zip(layouts.action, row.sent.tolist(), strict=True))
        cells |= {f"asked_{name}": value for name, value in zip(layouts.action, row.asked.tolist(), strict=True)}
        cells |= {f"age_{name}": age for name, age in reading.ages.items()}
        cells |= {} if math.isnan(reading.battery) else {"vbat": reading.battery}  # a car tells no voltage
        cells |= {"clock": reading.time, "late": row.late, "taken": row.taken}
        cells |= {"missed": float(row.missed), "stage": STAGES[row.stage], "verdict": float(row.command.verdict)}
        flags = " ".join(sorted(reading.flags))
        cells |= {"phase": row.command.phase, "reason": row.command.reason or NONE, "flags": flags or NONE}
        return cells | dict(reading.extra)

    def _describe(self, known: Mapping[str, Any]) -> None:
        try:
            import yaml  # noqa: PLC0415 — it comes with the extras of robots
        except ImportError as error:
            raise MissingDependencyError("a recorder needs pip install pyyaml") from error
        self._about |= {"robot": self._robot.name, "dt": self._robot.dt, **known}
        write_text(self.path.with_suffix(".yaml"), yaml.safe_dump(self._about, sort_keys=False, allow_unicode=True))


def task_of(path: str | Path, robot: Robot, name: str = "") -> Trajectory:
    """The part of a recorded run in which the task was flown, by the controller: its stamps are the true ones.

    Args:
        path: of a recorder's file, closed or not.
        robot: whose run it is.
        name: of the trajectory; the file's by default.

    Raises:
        DataError: when there are not two such rows with a whole state.
    """
    columns, layouts = read_table(path).columns, robot.layouts
    flown = (columns["stage"] == STAGES["task"]) & (columns["verdict"] == 0.0)
    both = (layouts.state, layouts.action)
    state, action = (np.stack([columns[one] for one in layout], axis=1)[flown] for layout in both)
    whole = np.isfinite(state).all(axis=1)
    time = columns["time"][flown][whole]
    if len(time) < 2:
        raise DataError(path, "two rows or more in which the task was flown", f"{len(time)}")
    inputs = np.zeros((len(time), layouts.inputs.size))
    extra = {one: columns[one][flown][whole] for one in columns if one not in {"time", *layouts.state, *layouts.action}}
    return Trajectory(time - time[0], state[whole], action[whole], inputs, layouts, extra, name or Path(path).stem)
