"""Data frames of pandas as logs, and logs as data frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sym2real.errors import DataError, needing
from sym2real.layout import Layouts
from sym2real.logs.missing import FRAME
from sym2real.logs.reader import log_of_table
from sym2real.logs.specification import LogSpec
from sym2real.logs.table import table_of
from sym2real.logs.writer import columns_of
from sym2real.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas

LAYOUTS = "layouts"  # entry of a frame's ``attrs``


def log_of_frame(
    frame: pandas.DataFrame,
    spec: LogSpec | str | Path | None = None,
    layouts: Layouts | None = None,
    dt: float | None = None,
) -> Trajectory:
    """See :meth:`~sym2real.Trajectory.from_pandas`."""
    if not hasattr(frame, "iloc"):
        raise DataError(FRAME, "a data frame of pandas (read_log reads files)", f"{frame!r:.80}")
    columns = [frame.iloc[:, place] for place in range(frame.shape[1])]
    cells = [
        column.to_numpy(dtype=np.float64, na_value=np.nan) if column.dtype.kind in "biuf" else [*map(str, column)]
        for column in columns
    ]
    known = {str(key): str(value) for key, value in frame.attrs.items()}
    table = table_of(FRAME, [str(name).strip() for name in frame.columns], cells, 0, known)
    return log_of_table(table, spec, layouts, dt)


def frame_of_log(trajectory: Trajectory) -> pandas.DataFrame:
    """See :meth:`~sym2real.Trajectory.to_pandas`."""
    with needing("to_pandas needs pandas", "pandas"):
        import pandas as pd  # noqa: PLC0415 — an extra
    frame = pd.DataFrame(columns_of(trajectory))
    frame.attrs |= {LAYOUTS: json.dumps(trajectory.layouts.to_dict()), "name": trajectory.name}
    return frame
