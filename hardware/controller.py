"""A model and its controller, opened, checked and warm before a robot arms."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from sym2real.errors import ModelError
from sym2real.layout import Layouts
from sym2real.robots import Robot
from sym2real.tasks import Task

if TYPE_CHECKING:
    from sym2real.control import MPPI, CorrectedMPPI
    from sym2real.neural import Model

WARM = 30  # actions before arming: the first ones compile and fill caches


def require_model_of(model: Model, name: str, robot: Robot) -> None:
    """Refuse the model of another robot, before anything warms up or arms.

    Args:
        model: opened.
        name: as the user names it.
        robot: that is to fly or drive.

    Raises:
        ModelError: for another robot's model, or one of other states or commands.
    """
    from sym2real.neural.model_folder import below  # noqa: PLC0415 — SymPy takes a second to load

    base = below(model)
    if base.robot not in ("", robot.name):
        raise ModelError(f"{name} is of a {base.robot}; this script is for a {robot.name}")
    _require_columns(name, base.layouts, robot.layouts)


def _require_columns(name: str, found: Layouts, wanted: Layouts) -> None:
    """Hidden states count for nothing."""
    seen = [column for field in found.state.fields if not field.hidden for column in field.columns]
    for group, columns, needed in (
        ("state", seen, wanted.state.columns),
        ("commands", found.action.columns, wanted.action.columns),
    ):
        if set(columns) != set(needed):
            raise ModelError(f"{name}: expected a model with the {group} {' '.join(needed)}, found {' '.join(columns)}")


def warm_controller(
    model: Model, robot: Robot, task: Task, *, samples: int | None, seed: int, say: Callable[[str], None]
) -> MPPI | CorrectedMPPI:
    """MPPI that has chosen some actions already, with as many samples as hold the control period here.

    Args:
        model: to plan with.
        robot: its limits and control period.
        task: what is wanted.
        samples: the robot's own number by default.
        seed: of the samples.
        say: is told how long an action takes.
    """
    from sym2real.control import mppi_controller  # noqa: PLC0415 — it takes a second to load

    say("warming the controller up")
    controller = mppi_controller(model, robot, task, samples=samples, seed=seed, period=robot.dt)
    nothing, taken = np.zeros(robot.layouts.inputs.size), []
    for step in range(WARM):
        start = time.perf_counter()
        controller.act(robot.start, step, nothing)
        taken.append(time.perf_counter() - start)
    say(f"an action of {controller.samples} samples takes {1000.0 * float(np.median(taken)):.1f} ms")
    controller.reset()
    return controller
