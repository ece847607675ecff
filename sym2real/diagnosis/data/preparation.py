"""Logs that are long enough, cut at gaps, with a name each, and with other columns."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Dataset, Logs, logs_in
from sym2real.diagnosis.data.start import ROWS
from sym2real.effects.along_logs import in_columns_of
from sym2real.errors import ShapeError
from sym2real.logs.dropouts import LEFT_OUT
from sym2real.logs.equal_steps import equal_steps
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations, equations_of
from sym2real.trajectory import Trajectory, require_finite
from sym2real.vocabulary import AT_A_STOP


def present(data: Dataset, columns: Sequence[str]) -> tuple[str, ...]:
    """Those of the columns that the logs have."""
    layouts = data.layouts
    return tuple(name for name in columns if name in layouts.state or name in layouts.action or name in layouts.inputs)


def long_enough(data: Logs, model: Equations | DynamicsModel | None = None) -> Dataset:
    """The logs that are longer than a window's history; the first of them notes which others were left out.

    Pieces between two gaps may be short; a noise or a time step cannot be told of a few rows.

    Args:
        data: logs.
        model: for which they are cut at gaps and brought to equal steps, as files are when they are read; None leaves
            them at their stamps.

    Raises:
        ShapeError: naming the logs, when none is long enough; naming log, row and column, for what is no finite number;
            for what is no log, and for columns of the model that a log lacks.
        ModelError: for what is no model.
    """
    logs = list(logs_in(data))
    for log in logs:
        require_finite(log)
    if model is not None:
        dt = equations.dt if (equations := equations_of(model)) else None
        logs = [piece for log in logs for piece in equal_steps(in_columns_of(model, log), dt)]
    kept, short = [log for log in logs if len(log) > ROWS], [log for log in logs if len(log) <= ROWS]
    if not kept:
        raise ShapeError(f"expected a log of more than {ROWS} rows without a gap, found {rows_of(short) or 'no log'}")
    if short:
        note = f"{LEFT_OUT}: {rows_of(short)}, where more than {ROWS} are needed"
        kept[0] = replace(kept[0], notes=(*kept[0].notes, note))
    return Dataset(kept)


def without_stops(log: Trajectory, rows: NDArray[np.int64], length: int) -> NDArray[np.int64]:
    """Those of the rows from which on no joint is at an end stop for so many; all of a log that has none."""
    met = np.cumsum(np.concatenate([[0.0], log.extra.get(AT_A_STOP, np.zeros(len(log)))]))
    free = rows[met[rows + length] == met[rows]]
    return free if len(free) else rows


def rows_of(logs: list[Trajectory]) -> str:
    """Every log with its number of rows, for a sentence."""
    return ", ".join(f"{len(log)} row{'s' if len(log) != 1 else ''} in {log.name or 'a log'}" for log in logs)
