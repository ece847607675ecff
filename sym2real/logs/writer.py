"""Trajectories to files, without loss: every float64 reads back as it was."""

from __future__ import annotations

import json
from pathlib import Path

from sym2real.errors import DataError, ShapeError
from sym2real.files import whole
from sym2real.logs import csv_file, parquet_file
from sym2real.logs.grouping import GROUPS, layouts_to_json
from sym2real.logs.table import COLUMNAR
from sym2real.trajectory import Array, Trajectory

TIME = "time"
WRITTEN = (".csv", *COLUMNAR)


def write_log(trajectory: Trajectory, path: str | Path) -> None:
    """Write a trajectory as CSV or Parquet, by the file's ending.

    Columns are ``time`` in s, then state, action, inputs and extra under their own names. A CSV reads back into the
    groups of the vocabulary or of the layouts that the reader is given; a Parquet file keeps layouts, name and notes
    in its metadata. The raw rows of the log it came from are not written.

    Raises:
        DataError: when the ending is neither, or there is no writing there.
        ShapeError: when two columns have one name.
    """
    target = Path(path)
    if target.suffix.lower() not in WRITTEN:
        raise DataError(target, f"a file name that ends in {', '.join(WRITTEN)}", repr(target.suffix))
    columns = _columns(trajectory)
    with whole(target) as beside:
        if target.suffix.lower() == ".csv":
            csv_file.write(beside, columns)
        else:
            parquet_file.write(beside, columns, _metadata(trajectory))


def _columns(trajectory: Trajectory) -> dict[str, Array]:
    columns: dict[str, Array] = {TIME: trajectory.time}
    parts = [
        dict(zip(getattr(trajectory.layouts, group).columns, getattr(trajectory, group).T, strict=True))
        for group in GROUPS
    ]
    for part in (*parts, trajectory.extra):
        for name, values in part.items():
            if name in columns:
                raise ShapeError(f"column {name!r} stands twice in trajectory {trajectory.name!r}")
            columns[name] = values
    return columns


def _metadata(trajectory: Trajectory) -> dict[str, str]:
    return {
        "layouts": layouts_to_json(trajectory.layouts),
        "name": trajectory.name,
        "notes": json.dumps(trajectory.notes),
    }
