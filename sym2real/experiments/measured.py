"""Robots that equations can be fitted to from logs alone: the registered ones, and any quadrotor or car."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sym2real.errors import UnknownNameError
from sym2real.layout import Layouts
from sym2real.logs import LogSpec
from sym2real.logs.inspect_time import nice_period
from sym2real.logs.reader import logs_of, read_each
from sym2real.logs.resample import REGULAR, usual_step
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.trajectory import Trajectory


class Measured(NamedTuple):
    """A robot whose logs are there."""

    like: Robot  # has its columns, and what must be known of these
    known: bool  # whether its numbers and its period are that robot's too; else it is any other one


# Robots of which no number is known, by what people call them.
LIKE: Mapping[str, Robot] = {"quadrotor": CRAZYFLIE, "car": MUSHR}


def measured(name: str) -> Measured:
    """What is known of a robot whose logs are there, by the name of a registered robot or of :data:`LIKE`.

    Raises:
        UnknownNameError: for another name.
    """
    if name not in {*ROBOTS, *LIKE}:
        raise UnknownNameError("robot", name, (*ROBOTS, *LIKE))
    return Measured(LIKE[name], known=False) if name in LIKE else Measured(ROBOTS[name], known=True)


def step_of(logs: Iterable[Sequence[Trajectory]]) -> float:
    """The usual step in s of the pieces of every log, of a whole number of rows a second where it is nearly that."""
    return nice_period(usual_step(np.concatenate([np.diff(one.time) for one in pieces]) for pieces in logs if pieces))


def step_of_logs(paths: Sequence[Path], spec: LogSpec | None, layouts: Layouts | None = None) -> float:
    """The same of files, of a robot with these columns, else the standard ones; the specification's step, if shorter.

    Raises:
        DataError: when one cannot be read.
    """
    as_recorded = None if spec is None else replace(spec, time=replace(spec.time, dt=None))
    recorded = step_of(read_each(logs_of(paths, as_recorded), as_recorded, layouts, None))
    stated = None if spec is None else spec.time.dt  # rows may be a slow sensor's, with commands between them
    return stated if stated is not None and stated < (1.0 - REGULAR) * recorded else recorded
