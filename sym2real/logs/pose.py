"""Where a body is and how it is turned, from whatever columns of a state say so."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch

from sym2real import rotation
from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.logs.derive import about_vertical, continuous, from_euler
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, HEADING, RATE


def attitudes(layout: Layout, states: Array) -> Array:
    """Attitudes w x y z ``# (rows, 4)`` of states ``# (rows, state)``; of a heading alone with roll and pitch zero."""
    there, rows = dict(zip(layout.columns, states.T, strict=True)), len(states)
    if _whole(ATTITUDE, there):
        return np.stack([there[column] for column in ATTITUDE.columns], axis=1)
    yaw = np.arctan2(*(there[column] for column in HEADING.columns)) if _whole(HEADING, there) else np.zeros(rows)
    return about_vertical(yaw)


def attitude(log: Trajectory) -> torch.Tensor:
    """Those of a log ``# (rows, 4)``."""
    return torch.as_tensor(attitudes(log.layouts.state, log.state))


def with_all_measured(log: Trajectory) -> Trajectory:
    """The log with an attitude and body rates in its state that are inputs of its model, or columns beside it."""
    state, known = log.layouts.state, {*log.layouts.inputs, *log.extra}
    more = [name for field in (ATTITUDE, RATE) if known.issuperset(field.columns) for name in field.columns]
    layouts = replace(log.layouts, state=Layout.of((*state.columns, *more)), inputs=Layout.of(()))
    values = np.column_stack([log.state, *(log.column(name) for name in more)])
    return replace(log, state=values, inputs=np.empty((len(log), 0)), layouts=layouts, extra={}) if more else log


def with_angles(log: Trajectory, angles: Array, quaternion: Sequence[str] = ATTITUDE.columns) -> Trajectory:
    """A log with other roll, pitch and yaw of a quaternion, or another yaw, in rad ``# (rows, 3 or 1)``."""
    if angles.shape[1] == 1:
        return log.with_columns(dict(zip(HEADING.columns, (np.sin(angles[:, 0]), np.cos(angles[:, 0])), strict=True)))
    return log.with_columns(dict(zip(quaternion, continuous(from_euler(angles)).T, strict=True)))


def turned(log: Trajectory, columns: Sequence[str], *, to_world: bool = True) -> Array:
    """A vector from body to world axes, or the other way ``# (rows, 3)``; a component that no column has is zero."""
    vector = np.zeros((len(log), 3))
    for place, name in enumerate(columns):
        vector[:, place] = log.column(name) if name in log.layouts.state else 0.0
    turn = attitude(log) if to_world else rotation.conjugate(attitude(log))
    return rotation.rotate(turn, torch.as_tensor(vector)).numpy()


def _whole(field: Field, there: dict[str, Array]) -> bool:
    return there.keys() >= set(field.columns)
