"""Trajectories to files, without loss: every float64 reads back as it was."""

import json
from collections import Counter
from pathlib import Path

from sym2real.errors import DataError, ShapeError
from sym2real.files import whole
from sym2real.logs import csv_file, parquet_file
from sym2real.logs.table import COLUMNAR
from sym2real.trajectory import Array, Trajectory

TIME = "time"
WRITTEN = (".csv", *COLUMNAR)


def write_log(trajectory: Trajectory, path: str | Path) -> None:
    """Write a trajectory as CSV or Parquet, by the file's ending.

    Columns are ``time`` in s, then state, action, inputs and extra under their own names. A CSV reads back into the
    groups of the vocabulary or of the layouts that the reader is given; Parquet keeps layouts, name and notes in its
    metadata. The raw rows of the log it came from are not written.

    Raises:
        DataError: when the ending is none of them, or there is no writing there.
        ShapeError: when two columns have one name.

    Examples:
        >>> log = read_log(example_flight(), "crazyflie_battery_drag").rows(0, 20)
        >>> write_log(log, "flight.parquet")
        >>> len(read_log("flight.parquet"))
        20
    """
    target = Path(path)
    if target.suffix.lower() not in WRITTEN:
        raise DataError(target, f"a file name that ends in {', '.join(WRITTEN)}", repr(target.suffix))
    columns = columns_of(trajectory)
    with whole(target) as beside:
        if target.suffix.lower() == ".csv":
            csv_file.write(beside, columns)
        else:
            parquet_file.write(beside, columns, _metadata(trajectory))


def columns_of(trajectory: Trajectory) -> dict[str, Array]:
    """Every column of a trajectory by its name, ``time`` first ``# (rows,)``.

    Raises:
        ShapeError: when two columns have one name.
    """
    columns = [(TIME, trajectory.time)]
    for group, layout in trajectory.layouts.groups.items():
        columns += zip(layout, getattr(trajectory, group).T, strict=True)
    columns += trajectory.extra.items()
    if repeated := [name for name, times in Counter(name for name, _ in columns).items() if times > 1]:
        raise ShapeError(f"column {repeated[0]!r} stands twice in trajectory {trajectory.name!r}")
    return dict(columns)


def _metadata(trajectory: Trajectory) -> dict[str, str]:
    return {
        "layouts": json.dumps(trajectory.layouts.to_dict()),
        "name": trajectory.name,
        "notes": json.dumps(trajectory.notes),
    }
