"""Trajectories from files: a table is read, its columns named, brought to the model's step, sorted into its groups."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from sym2real.dataset import Dataset
from sym2real.errors import DataError, reason
from sym2real.layout import Layouts
from sym2real.logs.dropouts import CUT, without_dropouts
from sym2real.logs.grouping import layouts_from_json, trajectory, visible
from sym2real.logs.of_model import for_model
from sym2real.logs.recordings import is_bag_folder
from sym2real.logs.resample import GAP_INTERVALS, gaps, is_regular, resample
from sym2real.logs.several_files import LogFiles, one_log_each, read_parts
from sym2real.logs.specification import LogSpec, load_spec
from sym2real.logs.standard import Standard, add_derived, own_specification, stamps, standardise, tidy, with_header
from sym2real.logs.table import IN_FOLDERS, Table, file_type
from sym2real.trajectory import Array, Trajectory

SHORTEST = 2  # rows; a single row between two gaps holds no transition
# Steps of the model between two rows; beyond, resampling would make up nineteen rows of twenty.
COARSEST = 20
# Rows to a step of the model; an 8 kHz gyro has 400 in 0.05 s, stamps in s that are read as ms a thousand.
FINEST = 500


def read_log(
    path: str | Path | Sequence[str | Path],
    spec: LogSpec | str | Path | None = None,
    layouts: Layouts | None = None,
    dt: float | None = None,
    columns: Sequence[str] = (),
) -> Trajectory:
    """One log as one trajectory.

    Args:
        path: CSV or Parquet file, or a recording (:mod:`sym2real.logs.recordings`); several files that are one log
            together (:mod:`sym2real.logs.several_files`).
        spec: what its columns mean: a specification, the name of a shipped one or a TOML file; None for a file
            with standard column names, which is taken as it stands.
        layouts: which columns the model has in which group; None for the groups of the vocabulary (a Parquet file
            of ours knows its own). Hidden states are left out: no log holds them.
        dt: the model's step in s. Rows at other stamps are resampled to it (see :mod:`sym2real.logs.resample`).
            None for the specification's ``time.dt``; where there is none either, rows stay as recorded.
        columns: names of the columns of text files that have no header.

    Raises:
        DataError: naming file, row, column, what was expected and what was found; also for a gap in the stamps,
            where :func:`read_logs` makes two trajectories.
        UnknownNameError: when there is no such specification.

    Examples:
        >>> log = read_log(example_flight(), "crazyflie_battery_drag")
        >>> log.layouts.action.columns
        ('motor1', 'motor2', 'motor3', 'motor4')
    """
    files = (Path(path),) if isinstance(path, str | Path) else tuple(Path(part) for part in path)
    known = with_header(_loaded(spec), columns)
    return log_of_table(_read(files, known), known, layouts, dt)


def log_of_table(
    table: Table, spec: LogSpec | str | Path | None = None, layouts: Layouts | None = None, dt: float | None = None
) -> Trajectory:
    """A table as one trajectory; arguments and errors as of :func:`read_log`."""
    log = _Opened.open(table, _loaded(spec), layouts, dt)
    if log.gaps:
        row = log.gaps[0]
        interval = log.standard.time[row] - log.standard.time[row - 1]
        raise log.table.error(
            f"stamps at most {GAP_INTERVALS} steps apart in one log (what lies between gaps are logs of their own)",
            f"a gap of {interval:.4g} s before this row, at {log.standard.time[row]:.4g} s",
            row,
            log.spec.time.column,
        )
    return log.trajectory(0, len(log.table), "")


def read_logs(
    paths: str | Path | Iterable[str | Path],
    spec: LogSpec | str | Path | None = None,
    layouts: Layouts | None = None,
    dt: float | None = None,
    columns: Sequence[str] = (),
) -> Dataset:
    """Several logs; a folder stands for the logs in it, but a ROS 2 bag's for one log.

    Files that have no column in common but stamps are parts of one log (:mod:`sym2real.logs.several_files`).
    Arguments and errors are those of :func:`read_log`, but a log with gaps is split at them into trajectories named
    ``file#1``, ``file#2`` …; pieces of a single row are left out.

    Examples:
        >>> len(read_logs([example_flight()], "crazyflie_battery_drag"))
        1
    """
    trajectories: list[Trajectory] = []
    known = with_header(_loaded(spec), columns)
    for files in logs_of(paths, known):
        log = _Opened.open(_read(files, known), known, layouts, dt)
        bounds = [0, *log.gaps, len(log.table)]
        pieces = [(a, b) for a, b in pairwise(bounds) if b - a >= SHORTEST or len(bounds) == 2]
        if not pieces:
            raise DataError(log.table.path, "two or more rows without a gap between them", "gaps between all rows")
        suffixes = [f"#{i + 1}" for i in range(len(pieces))] if log.gaps else [""]
        trajectories += [log.trajectory(*piece, suffix) for piece, suffix in zip(pieces, suffixes, strict=True)]
    return Dataset(trajectories)


def logs_of(paths: str | Path | Iterable[str | Path], spec: LogSpec | None = None) -> list[LogFiles]:
    """The files of each log of the list, folders replaced by the logs in them.

    Raises:
        DataError: when there is no file at all, or files do not belong together.
    """
    return one_log_each(expand(paths), () if spec is None else spec.header)


def expand(paths: str | Path | Iterable[str | Path]) -> list[Path]:
    """Files of the list, with every folder replaced by the logs in it, in the order of their names.

    Raises:
        DataError: when there is no file at all.
    """
    given = [Path(paths)] if isinstance(paths, str | Path) else [Path(path) for path in paths]
    files: list[Path] = []
    for path in given:
        if path.is_dir() and not is_bag_folder(path):
            inside = sorted(file for file in path.iterdir() if file_type(file) in IN_FOLDERS)
            if not inside:
                raise DataError(path, f"files that end in {', '.join(IN_FOLDERS)}", "none")
            files += inside
        else:
            files.append(path)
    if not files:
        raise DataError("logs", "one file or more", "none")
    return files


def _loaded(spec: LogSpec | str | Path | None) -> LogSpec | None:
    return None if spec is None else load_spec(spec)


def _read(files: LogFiles, spec: LogSpec | None) -> Table:
    return read_parts(files, spec.sources if spec else None, spec.header if spec else ())


def _first_stamp(whole: Table, spec: LogSpec) -> float:
    """Time of the file's first row that has one, s."""
    named = [spec.time.column] if spec.time.column else []
    return float(stamps(without_dropouts(whole, named)[0].rows(0, 1), spec)[0])


@dataclass(frozen=True, eq=False)
class _Opened:
    """A log that has been read and named, before it is cut and sorted."""

    whole: Table
    table: Table
    spec: LogSpec
    layouts: Layouts | None
    standard: Standard
    dt: float | None
    gaps: list[int]

    @classmethod
    def open(cls, whole: Table, given: LogSpec | None, layouts: Layouts | None, dt: float | None) -> _Opened:
        """Name the columns of a log; arguments and errors as of :func:`read_log`."""
        found = layouts or _own_layouts(whole)
        known = None if found is None else visible(found)
        used = for_model(given or own_specification((*whole.columns, *whole.texts)), whole, known)
        rows = len(whole) - used.drop_first - used.drop_last
        if rows < 1:
            raise DataError(
                whole.path, f"more than the {used.drop_first + used.drop_last} rows to drop", f"{len(whole)}"
            )
        table, left_out = without_dropouts(whole.rows(used.drop_first, used.drop_first + rows), used.sources, used.hold)
        standard = standardise(table, used)
        standard = replace(standard, notes=()) if given is None else tidy(standard, _first_stamp(whole, used))
        if dropped := len(whole) - rows:
            note = f"{dropped} of {len(whole)} rows dropped at the ends"
            standard = replace(standard, notes=(*standard.notes, note))
        standard = replace(standard, notes=(*standard.notes, *left_out))
        step = dt if dt is not None else used.time.dt
        # Where rows are missing, a log is in pieces whether anybody asks for equal steps or not.
        cuts = [] if step is None and not left_out else gaps(standard.time, step or 0.0).tolist()
        return cls(whole, table, used, known, standard, step, cuts)

    def trajectory(self, start: int, stop: int, suffix: str) -> Trajectory:
        """Rows ``start`` to ``stop``; a suffix of the name says that it was cut."""
        log = self.standard.rows(start, stop)
        if suffix:
            note = f"{CUT}: rows {self.table.line(start)} to {self.table.line(stop - 1)}"
            log = replace(log, notes=(*log.notes, note))
        log = add_derived(log, self.spec, self.layouts)
        known = self.layouts or Layouts.of(log.columns)
        if not known.state.size:
            names = ", ".join(self.whole.columns)
            raise DataError(self.table.path, "standard state columns, or a log specification", f"columns {names}")
        every = 0.0
        if self.dt is not None and len(log.time) > 1 and not is_regular(log.time, self.dt):
            self._require_rows_for(self.dt, log.time)
            every, log = float(np.median(np.diff(log.time))), resample(log, self.dt, known)
        name = _metadata(self.table, "name") or self.table.path.stem
        result = trajectory(self.table, log, known, name + suffix)
        return replace(
            result, raw=self.whole.columns, notes=_own_notes(self.table) + result.notes, measured_every=every
        )

    def _require_rows_for(self, dt: float, time: Array) -> None:
        apart = float(np.median(np.diff(time)))
        if apart > COARSEST * dt:
            raise DataError(
                self.table.path,
                f"rows at most {COARSEST:g} of the model's steps of {dt:g} s apart (is the unit of the stamps right?)",
                f"{apart:.4g} s",
                column=self.spec.time.column or None,
            )
        if apart * FINEST < dt:
            raise DataError(
                self.table.path,
                f"at most {FINEST} rows in one of the model's steps of {dt:g} s (is the unit of the stamps right?)",
                f"rows {apart:.4g} s apart",
                column=self.spec.time.column or None,
            )


def _metadata(table: Table, key: str) -> str:
    return (table.metadata or {}).get(key, "")


def _own_notes(table: Table) -> tuple[str, ...]:
    try:
        notes = json.loads(_metadata(table, "notes") or "[]")
        if not isinstance(notes, list):
            raise TypeError(f"{notes!r:.80}")
        return tuple(str(note) for note in notes)
    except (TypeError, ValueError, RecursionError) as error:
        raise DataError(table.path, "notes in the file's metadata, a JSON list", reason(error)) from None


def _own_layouts(table: Table) -> Layouts | None:
    text = _metadata(table, "layouts")
    try:
        return layouts_from_json(text) if text else None
    except (KeyError, ValueError, RecursionError) as error:
        raise DataError(table.path, "layouts in the file's metadata", reason(error)) from None
