"""Logs long enough to predict anything of: a window needs ten rows of history and one more."""

from __future__ import annotations

from dataclasses import replace

from sym2real.dataset import Dataset, Logs
from sym2real.diagnosis.data.start import ROWS
from sym2real.errors import ShapeError
from sym2real.logs.dropouts import LEFT_OUT
from sym2real.trajectory import Trajectory


def long_enough(data: Logs) -> Dataset:
    """The logs that are longer than a window's history; the first of them notes which others were left out.

    Pieces between two gaps may be short; a noise or a time step cannot be told of a few rows.

    Raises:
        ShapeError: naming the logs, when none is long enough.
    """
    logs = [data] if isinstance(data, Trajectory) else list(data)
    kept, short = [log for log in logs if len(log) > ROWS], [log for log in logs if len(log) <= ROWS]
    if not kept:
        raise ShapeError(f"expected a log of more than {ROWS} rows without a gap, found {rows_of(short)}")
    if short:
        note = f"{LEFT_OUT}: {rows_of(short)}, where more than {ROWS} are needed"
        kept[0] = replace(kept[0], notes=(*kept[0].notes, note))
    return Dataset(kept)


def rows_of(logs: list[Trajectory]) -> str:
    """Every log with its number of rows, for a sentence."""
    return ", ".join(f"{len(log)} row{'s' if len(log) != 1 else ''} in {log.name or 'a log'}" for log in logs)
