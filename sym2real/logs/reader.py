"""Trajectories from files: a table is read, its columns named, brought to the model's step, sorted into its groups."""

from collections.abc import Iterable, Sequence
from itertools import chain, pairwise
from pathlib import Path

from sym2real.dataset import Dataset
from sym2real.errors import DataError
from sym2real.layout import Layouts
from sym2real.logs.opened import Opened, in_step
from sym2real.logs.recordings import is_bag_folder
from sym2real.logs.recordings.recording import ColumnKinds
from sym2real.logs.resample import GAP_INTERVALS
from sym2real.logs.several_files import LogFiles, files_by_log, read_parts
from sym2real.logs.sources import commands_of
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import with_header
from sym2real.logs.table import IN_FOLDERS, Table, file_type
from sym2real.trajectory import Trajectory

SHORTEST = 2  # rows; a single row between two gaps holds no transition


def read_log(
    path: str | Path | Sequence[str | Path],
    spec: LogSpec | str | Path | None = None,
    layouts: Layouts | None = None,
    dt: float | None = None,
    columns: Sequence[str] = (),
    *,
    upsample: bool = False,
) -> Trajectory:
    """One log as one trajectory.

    Args:
        path: CSV or Parquet file, or a recording (:mod:`sym2real.logs.recordings`); several files that are one log
            together (:mod:`sym2real.logs.several_files`).
        spec: what its columns mean: a specification, the name of a shipped one or a TOML file; None for a file
            with standard column names, which is taken as it stands.
        layouts: which columns the model has in which group; None for the groups of the vocabulary (a Parquet file
            of ours knows its own). Hidden states are left out: no log holds them.
        dt: the model's step in s. Rows at other stamps are resampled to it (see :mod:`sym2real.logs.resample`), those
            of a slower log to its own median step: what lies between them was never measured.
            None for the specification's ``time.dt``; where there is none either, rows stay as recorded.
        columns: names of the columns of text files that have no header.
        upsample: whether rows of a slower log are resampled to ``dt`` all the same, for what needs a row each step.

    Raises:
        DataError: naming file, row, column, what was expected and what was found; also for a gap in the stamps,
            where :func:`read_logs` makes two trajectories.
        UnknownNameError: when there is no such specification.

    Examples:
        >>> log = read_log(example_flight(), "crazyflie_battery_drag")
        >>> log.layouts.action.columns
        ('motor1', 'motor2', 'motor3', 'motor4')
    """
    files = (Path(path),) if isinstance(path, str | Path) else tuple(map(Path, path))
    known = with_header(spec, columns)
    return log_of_table(_read(files, known, layouts), known, layouts, dt, upsample=upsample)


def log_of_table(
    table: Table,
    spec: LogSpec | str | Path | None = None,
    layouts: Layouts | None = None,
    dt: float | None = None,
    *,
    upsample: bool = False,
) -> Trajectory:
    """A table as one trajectory; arguments and errors as of :func:`read_log`."""
    (log,) = in_step([Opened.open(table, with_header(spec), layouts, dt)], upsample)
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
    *,
    upsample: bool = False,
) -> Dataset:
    """Several logs; a folder stands for the logs in it, but a ROS 2 bag's for one log.

    Files that have no column in common but stamps are parts of one log (:mod:`sym2real.logs.several_files`).
    Arguments and errors are those of :func:`read_log`, but a log with gaps is split at them into trajectories named
    ``file#1``, ``file#2`` …; pieces of a single row are left out. All get the step of the slowest.

    Examples:
        >>> len(read_logs([example_flight()], "crazyflie_battery_drag"))
        1
    """
    known = with_header(spec, columns)
    return Dataset(chain(*read_each(logs_of(paths, known), known, layouts, dt, upsample=upsample)))


def read_each(
    logs: Iterable[LogFiles], spec: LogSpec | None, layouts: Layouts | None, dt: float | None, *, upsample: bool = False
) -> list[list[Trajectory]]:
    """The trajectories of each of :func:`logs_of`; arguments and errors as of :func:`read_logs`."""
    trajectories: list[list[Trajectory]] = []
    opened = [Opened.open(_read(files, spec, layouts), spec, layouts, dt) for files in logs]
    for log in in_step(opened, upsample):
        bounds = [0, *log.gaps, len(log.table)]
        pieces = [(a, b) for a, b in pairwise(bounds) if b - a >= SHORTEST or len(bounds) == 2]
        if not pieces:
            raise DataError(log.table.path, "two or more rows without a gap between them", "gaps between all rows")
        suffixes = [f"#{i + 1}" for i in range(len(pieces))] if log.gaps else [""]
        trajectories.append([log.trajectory(*piece, suffix) for piece, suffix in zip(pieces, suffixes, strict=True)])
    return trajectories


def logs_of(paths: str | Path | Iterable[str | Path], spec: LogSpec | None = None) -> list[LogFiles]:
    """The files of each log of the list, folders replaced by the logs in them.

    Raises:
        DataError: when there is no file at all, or files do not belong together.
    """
    return files_by_log(expand(paths), () if spec is None else spec.header)


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


def _read(files: LogFiles, spec: LogSpec | None, layouts: Layouts | None) -> Table:
    if spec is None:
        return read_parts(files)
    commands, joints = commands_of(spec, layouts), layouts.state.joints if layouts else ()
    actual = (source.column for name, source in spec.columns.items() if not name.startswith("ref_"))
    sent = {column: column in commands for column in actual}
    turning = [source.column for name, source in spec.columns.items() if name in {"yaw", "ref_yaw", *joints}]
    attitudes = (spec.attitude, spec.attitude_command, spec.reference_attitude)
    euler = [column for attitude in attitudes for column in attitude.euler]
    quaternions = [attitude.quaternion for attitude in attitudes if attitude.quaternion]
    return read_parts(files, spec.sources, spec.header, ColumnKinds(sent, {*turning, *euler}, quaternions))
