"""The speed of a car's wheels, which a log may have in place of a velocity: the part of that along the heading.

The position tells where the car was when its pose was measured, the wheel how fast it went when the row was written. So
the two tell how late a pose is, and how many times too fast a wheel.
"""

from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.logs import derive
from sym2real.logs.derived import rates
from sym2real.logs.pose import turned
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, VELOCITY

LEVEL = VELOCITY.columns[:2]


def made_of_wheel(data: Dataset) -> tuple[str, ...]:
    """The velocities that the reader has made of one column, the wheel's; none of other logs."""
    own = {log.sources.get(name) for log in data for name in LEVEL}
    return LEVEL if len(own) == 1 and None not in own and data.layouts.state.has_field(HEADING.name) else ()


def along(log: Trajectory) -> Array:
    """Velocity along the heading in m/s ``# (rows,)``."""
    return np.asarray((_ahead(log) * log.state[:, log.layouts.state.indices(LEVEL)]).sum(1))


def way(log: Trajectory) -> Array:
    """How far a car goes along its heading from row to row in m ``# (rows - 1,)``."""
    ahead, place = _ahead(log), log.layouts.state.indices(POSITION.columns[:2])
    return np.asarray((0.5 * (ahead[1:] + ahead[:-1]) * np.diff(log.state[:, place], axis=0)).sum(1))


def with_along(log: Trajectory, speed: Array) -> Trajectory:
    """The log with another velocity along the heading, m/s ``# (rows,)``."""
    state, place = log.state.copy(), log.layouts.state.indices(LEVEL)
    state[:, place] += (speed - along(log))[:, None] * _ahead(log)
    return replace(log, state=state)


def made_anew(before: Trajectory, log: Trajectory) -> Trajectory:
    """A log whose pose is not what it was before, with what the reader makes by it: rates, and velocities.

    Those of wheels, and those that stand in the log along the body's axes.
    """
    state, around = log.layouts.state, derive.rows_around(log.time, log.dt)
    pose = state.indices(name for field in (POSITION, ATTITUDE, HEADING) for name in field.columns if name in state)
    if not log.sources or np.array_equal(before.state[:, pose], log.state[:, pose]):
        return log
    turning = rates(log.time, dict(zip(state, log.state.T, strict=True)), around)
    computed = {name: values for name, values in turning.items() if name in state and name not in log.sources}
    if made := made_of_wheel(Dataset([before])):
        speed, logged = along(before), log.raw.get(log.sources[made[0]])
        place, yaw = log.state[:, state.indices(POSITION.columns[:2])], np.arctan2(*log.state[:, _heading(log)].T)
        speed = speed if logged is None or logged.min() < 0.0 else np.abs(speed)
        computed |= dict(zip(made, derive.rolling(log.time, place, yaw, speed, around).T, strict=True))
    if own := log.along_body:
        posed = log.with_columns(dict(zip(own, turned(before, own, to_world=False).T, strict=False)))
        computed |= dict(zip(own, turned(posed, own).T, strict=False))
    return log.with_columns(computed)


def _ahead(log: Trajectory) -> Array:
    return log.state[:, _heading(log)[::-1]]


def _heading(log: Trajectory) -> list[int]:
    return log.layouts.state.indices(HEADING.columns)
