"""Trajectories to files, without loss: every float64 reads back as it was."""

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from sym2real.errors import DataError, ShapeError
from sym2real.files import whole
from sym2real.logs import csv_file, parquet_file
from sym2real.logs.grouping import EXTRA, layouts_to_json
from sym2real.logs.recordings import mcap_writer
from sym2real.logs.table import COLUMNAR
from sym2real.trajectory import Array, Trajectory

TIME = "time"
MCAP = ".mcap"
WRITTEN = (".csv", *COLUMNAR, MCAP)


def write_log(trajectory: Trajectory, path: str | Path) -> None:
    """Write a trajectory as CSV, Parquet or MCAP, by the file's ending.

    Columns are ``time`` in s, then state, action, inputs and extra under their own names. A CSV reads back into the
    groups of the vocabulary or of the layouts that the reader is given; Parquet and MCAP keep layouts, name and notes
    in their metadata. The raw rows of the log it came from are not written.

    Raises:
        DataError: when the ending is none of them, or there is no writing there.
        ShapeError: when two columns have one name.
        MissingDependencyError: for MCAP, without the extra ``recordings``.

    Examples:
        >>> log = read_log(example_flight(), "crazyflie_battery_drag").rows(0, 20)
        >>> write_log(log, "flight.parquet")
        >>> len(read_log("flight.parquet"))
        20
    """
    target = Path(path)
    if target.suffix.lower() not in WRITTEN:
        raise DataError(target, f"a file name that ends in {', '.join(WRITTEN)}", repr(target.suffix))
    groups = _groups(trajectory)
    columns = _joined(groups)
    with whole(target) as beside:
        if target.suffix.lower() == ".csv":
            csv_file.write(beside, columns)
        elif target.suffix.lower() == MCAP:
            mcap_writer.write(beside, groups, trajectory, _metadata(trajectory))
        else:
            parquet_file.write(beside, columns, _metadata(trajectory))


def columns_of(trajectory: Trajectory) -> dict[str, Array]:
    """Every column of a trajectory by its name, ``time`` first ``# (rows,)``.

    Raises:
        ShapeError: when two columns have one name.
    """
    return _joined(_groups(trajectory))


def _joined(groups: Mapping[str, Mapping[str, Array]]) -> dict[str, Array]:
    return {name: values for part in groups.values() for name, values in part.items()}


def _groups(trajectory: Trajectory) -> dict[str, dict[str, Array]]:
    """Columns by their group; the time stands with the states."""
    groups: dict[str, dict[str, Array]] = {
        group: dict(zip(layout, getattr(trajectory, group).T, strict=True))
        for group, layout in trajectory.layouts.groups.items()
    } | {EXTRA: dict(trajectory.extra)}
    names = Counter([TIME, *(name for columns in groups.values() for name in columns)])
    if repeated := [name for name, times in names.items() if times > 1]:
        raise ShapeError(f"column {repeated[0]!r} stands twice in trajectory {trajectory.name!r}")
    return groups | {"state": {TIME: trajectory.time, **groups["state"]}}


def _metadata(trajectory: Trajectory) -> dict[str, str]:
    return {
        "layouts": layouts_to_json(trajectory.layouts),
        "name": trajectory.name,
        "notes": json.dumps(trajectory.notes),
    }
