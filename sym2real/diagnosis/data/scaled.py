"""Logs with columns divided by a number: in another unit, or with the other sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sym2real.dataset import Dataset
from sym2real.trajectory import Trajectory


def divided(data: Dataset, columns: Sequence[str], factor: float, only: int | None = None) -> Dataset:
    """The logs with columns of state and action divided.

    Args:
        columns: names; those that a log does not have are passed over.
        factor: what they are divided by.
        only: place of the one log that is changed; None for all.
    """
    return Dataset(_divided(log, columns, factor) if only in (None, place) else log for place, log in enumerate(data))


def _divided(log: Trajectory, columns: Sequence[str], factor: float) -> Trajectory:
    state, action = log.state.copy(), log.action.copy()
    for values, layout in ((state, log.layouts.state), (action, log.layouts.action)):
        values[:, layout.indices([name for name in columns if name in layout])] /= factor
    return replace(log, state=state, action=action)
