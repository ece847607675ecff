"""Robots that equations can be fitted to from logs alone: the registered ones, and any quadrotor or car."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from sym2real.dataset import Dataset
from sym2real.errors import UnknownNameError
from sym2real.layout import Layouts
from sym2real.logs import LogSpec, read_logs
from sym2real.logs.inspect_time import nice_period
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot


@dataclass(frozen=True, eq=False)
class Measured:
    """What must be known of a robot whose logs are there.

    Args:
        robot: name of a registered robot; empty for any other.
        layouts: state and action; nobody knows the wrench of a log.
        angles: columns that may stand inside sin and cos.
        dependencies: pairs (state column, action column): that action must show in that state's equation.
        dt: control period in s; None for the step of the logs.
        numbers: of the robot in SI units, as far as they are known.
        names: of numbers that effects can use.
    """

    robot: str
    layouts: Layouts
    angles: tuple[str, ...]
    dependencies: tuple[tuple[str, str], ...]
    dt: float | None
    numbers: Mapping[str, float] = field(default_factory=dict)
    names: Collection[str] = ()

    @classmethod
    def registered(cls, robot: Robot) -> Measured:
        """A robot whose numbers are known."""
        layouts = Layouts(robot.layouts.state, robot.layouts.action)
        numbers, recipe = robot.numbers, robot.recipe
        return cls(robot.name, layouts, recipe.angles, recipe.dependencies, robot.dt, numbers, tuple(numbers))

    @classmethod
    def like(cls, robot: Robot) -> Measured:
        """Any robot with the columns of a registered one, of which no number is known."""
        layouts = Layouts(robot.layouts.state, robot.layouts.action)
        return cls("", layouts, robot.recipe.angles, robot.recipe.dependencies, None, names=tuple(robot.numbers))


# Robots of which no number is known, by what people call them.
LIKE: Mapping[str, Robot] = {"quadrotor": CRAZYFLIE, "car": MUSHR}


def measured(name: str) -> Measured:
    """What is known of a robot whose logs are there, by the name of a registered robot or of :data:`LIKE`.

    Raises:
        UnknownNameError: for another name.
    """
    if name in LIKE:
        return Measured.like(LIKE[name])
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, (*ROBOTS, *LIKE))
    return Measured.registered(ROBOTS[name])


def step_of(logs: Dataset) -> float:
    """The usual step of logs in s, of a whole number of rows a second where it is nearly that."""
    return nice_period(float(np.median(np.concatenate([np.diff(log.time) for log in logs]))))


def step_of_logs(paths: Sequence[Path], spec: LogSpec | None, layouts: Layouts | None = None) -> float:
    """The same of files, of a robot with these columns; of the standard ones without.

    Raises:
        DataError: when one cannot be read.
    """
    as_recorded = None if spec is None else replace(spec, time=replace(spec.time, dt=None))
    return step_of(read_logs(paths, spec=as_recorded, layouts=layouts))
