"""Logs with other values in some of their columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sym2real.dataset import Dataset
from sym2real.trajectory import Array, Trajectory


def with_columns(log: Trajectory, columns: dict[str, Array]) -> Trajectory:
    """The log with other values ``# (rows,)`` in columns of its three groups."""
    changed = {}
    for group in ("state", "action", "inputs"):
        layout, values = getattr(log.layouts, group), getattr(log, group).copy()
        for name in (name for name in columns if name in layout):
            values[:, layout.index(name)] = columns[name]
        changed[group] = values
    return replace(log, **changed)


def divided(data: Dataset, columns: Sequence[str], factor: float, only: int | None = None) -> Dataset:
    """The logs with columns divided by a number; ``only`` in the one at this place, None for all."""
    return Dataset(
        with_columns(log, {name: log.column(name) / factor for name in columns}) if only in (None, place) else log
        for place, log in enumerate(data)
    )
