"""Where a body is and how it is turned, from whatever columns of a state say so; for viewers that draw in space."""

from __future__ import annotations

import numpy as np

from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION


def poses(layout: Layout, states: Array) -> tuple[Array, Array] | None:
    """Positions in m ``# (rows, 3)`` and attitudes w x y z ``# (rows, 4)`` of states ``# (rows, state)``, in the world.

    What a state does not say is zero: a car's height, its roll and pitch. None where it holds no position.
    """
    there = dict(zip(layout.columns, states.T, strict=True))
    if not there.keys() & set(POSITION.columns):
        return None
    rows = len(states)
    position = np.stack([there.get(column, np.zeros(rows)) for column in POSITION.columns], axis=1)
    if _whole(ATTITUDE, there):
        return position, np.stack([there[column] for column in ATTITUDE.columns], axis=1)
    yaw = np.arctan2(*(there[column] for column in HEADING.columns)) if _whole(HEADING, there) else np.zeros(rows)
    return position, np.stack([np.cos(yaw / 2), np.zeros(rows), np.zeros(rows), np.sin(yaw / 2)], axis=1)


def _whole(field: Field, there: dict[str, Array]) -> bool:
    return there.keys() >= set(field.columns)
