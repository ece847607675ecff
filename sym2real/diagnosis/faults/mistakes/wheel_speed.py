"""The speed of a car's wheels, which a log may have in place of a velocity: the part of that along the heading.

The position tells where the car was when its pose was measured, the wheel how fast it went when the row was written. So
the two tell how late a pose is, and how many times too fast a wheel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.agreement import VELOCITIES
from sym2real.diagnosis.faults.mistakes.transformation import Late
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING, POSITION, RATE

LEVEL = VELOCITIES[:2]


def made_of_wheel(data: Dataset) -> tuple[str, ...]:
    """The velocities that the reader has made of one column, the wheel's; none of other logs."""
    own = {log.sources.get(name) for log in data for name in LEVEL}
    return LEVEL if len(own) == 1 and None not in own and data.layouts.state.has_field(HEADING.name) else ()


def along(log: Trajectory) -> Array:
    """Velocity along the heading in m/s ``# (rows,)``."""
    found: Array = (_ahead(log) * log.state[:, log.layouts.state.indices(LEVEL)]).sum(1)
    return found


def way(log: Trajectory) -> Array:
    """How far a car goes along its heading from row to row in m ``# (rows - 1,)``."""
    ahead, place = _ahead(log), log.layouts.state.indices(POSITION.columns[:2])
    found: Array = (0.5 * (ahead[1:] + ahead[:-1]) * np.diff(log.state[:, place], axis=0)).sum(1)
    return found


def with_along(log: Trajectory, speed: Array) -> Trajectory:
    """The log with another velocity along the heading, m/s ``# (rows,)``."""
    state, place = log.state.copy(), log.layouts.state.indices(LEVEL)
    state[:, place] += (speed - along(log))[:, None] * _ahead(log)
    return replace(log, state=state)


@dataclass(frozen=True)
class LatePose(Late):
    """A pose some rows behind the wheel's speed and the commands, and with it what the reader has made of it."""

    def undone(self, log: Trajectory) -> Trajectory:
        """Shifted back, beside the speed as it stands."""
        made = tuple(name for name in RATE.columns if name in log.layouts.state and name not in log.sources)
        speed = along(log)
        return with_along(Late.undone(replace(self, columns=(*self.columns, *LEVEL, *made)), log), speed)


def _ahead(log: Trajectory) -> Array:
    return log.state[:, log.layouts.state.indices(HEADING.columns[::-1])]
