"""What verbs share: opening a model with progress, and logs with the columns that the model needs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from sym2real.cli.progress import stage_one_progress
from sym2real.errors import ModelError
from sym2real.experiments.models import open_model
from sym2real.logs import read_logs
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset


def open_with_progress(name: str, console: Console) -> Equations:
    """The model of that name; a robot's base is learned under a progress bar when it is not cached yet."""
    with stage_one_progress(console) as on_progress:
        return open_model(name, on_progress)


def robot_of(equations: Equations, model: str) -> Robot:
    """The robot that a model describes.

    Raises:
        ModelError: when the model does not say, or says a robot that is not registered.
    """
    if equations.robot not in ROBOTS:
        known = ", ".join(ROBOTS)
        raise ModelError(f"{model}: expected the model of a registered robot ({known}), found {equations.robot!r}")
    return ROBOTS[equations.robot]


def logs_for(equations: Equations, paths: Sequence[Path], spec: str | None) -> Dataset:
    """Logs read with the columns and the time step of a model."""
    return read_logs(paths, spec=spec, layouts=equations.layouts, dt=equations.dt)
