"""What a robot is asked to do: a reference over time, a running cost, where episodes start and how long they last."""

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import sympy
import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.robots.robot import Robot
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, HEADING, POSITION, RATE, VELOCITY

ROWS = 101  # of a reference that tell it from another
# States that references of paths are made of: of a free body, and of a vehicle in the plane.
FLOWN = (*POSITION.columns, *ATTITUDE.columns, *VELOCITY.columns, *RATE.columns)
DRIVEN = (*POSITION.columns[:2], *HEADING.columns, *VELOCITY.columns[:2], RATE.columns[2])
Reference = Callable[[Tensor], Tensor]
Cost: TypeAlias = sympy.Expr | Callable[[Tensor, Tensor, Tensor], Tensor]


@dataclass(frozen=True)
class Task:
    """One task of one robot.

    Args:
        name: what a user calls it.
        reference: full state wanted at a time in s: ``# (...,)`` → ``# (..., state)``, in the dtype of the time.
            It is of time alone, and defined beyond the episode: controllers ask ahead.
        cost: running cost of one step: a SymPy expression over state columns, action columns and reference
            columns (``ref_x``, …), or a callable of state ``# (..., state)``, action ``# (..., action)`` and
            reference ``# (..., state)``, broadcast → ``# (...,)``. The state is the one after the action.
        start: draws the state ``# (state,)`` that an episode starts from.
        duration: length of an episode, s.

    Examples:
        >>> task = make_task("circle", ROBOTS["mushr"], radius=2.0)
        >>> isinstance(task, Task), task.reference(torch.zeros(1)).shape
        (True, torch.Size([1, 7]))
    """

    name: str
    reference: Reference
    cost: Cost
    start: Callable[[np.random.Generator], Array]
    duration: float


def digest_of_reference(task: Task) -> str:
    """What tells a task from another of the same name: its reference over its duration, to a millionth."""
    time = torch.linspace(0.0, task.duration, ROWS, dtype=torch.float64)
    rows = np.round(task.reference(time).numpy(), 6) + 0.0  # no -0.0
    return hashlib.sha256(rows.tobytes()).hexdigest()[:16]


def flies(robot: Robot) -> bool:
    """True of robots that move in space with a free attitude, false of those that drive in a plane."""
    return robot.layouts.state.has_field("attitude")


def motion(robot: Robot) -> Literal["flight", "drive"]:
    """How a robot moves: the key of tables that give sizes and speeds for either.

    Raises:
        ShapeError: for a robot that follows no path.
    """
    if not follows_paths(robot):
        raise ShapeError(
            f"paths are for robots whose state is {' '.join(FLOWN)}, or {' '.join(DRIVEN)}; {robot.name} has "
            f"{' '.join(robot.layouts.state)}: the task 'regulate' is for any robot"
        )
    return "flight" if flies(robot) else "drive"


def follows_paths(robot: Robot) -> bool:
    """Whether a robot's state is that of a free body or of a vehicle in the plane, and no joint's beside it."""
    return robot.layouts.state.columns in (FLOWN, DRIVEN)


def require(robot: Robot, field: str, task: str) -> None:
    """Refuse a task that a robot cannot be given.

    Raises:
        ShapeError: when the robot's state lacks a field of that name, or follows no path.
    """
    layout = robot.layouts.state
    if not layout.has_field(field):
        have = ", ".join(known.name for known in layout.fields)
        raise ShapeError(f"task {task!r} needs a robot with the field {field!r} in its state; {robot.name} has {have}")
    motion(robot)


def require_positive(task: str, **sizes: float) -> None:
    """Refuse sizes, speeds and times of a task that no path has.

    Raises:
        ShapeError: with the first that is not a positive number.
    """
    for name, value in sizes.items():
        if not 0.0 < value < math.inf:
            raise ShapeError(f"task {task!r}: expected {name} > 0, found {value!r}")


def require_numbers(task: str, name: str, values: Sequence[float], count: int) -> list[float]:
    """A place as so many numbers.

    Raises:
        ShapeError: for another number of them, or one that is not finite.
    """
    numbers = [float(value) for value in values]
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ShapeError(f"task {task!r}: expected {name} as {count} finite numbers in m, found {numbers}")
    return numbers
