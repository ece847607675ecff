"""What the comparison runs on: fixed equations, networks with random weights, and one constant goal for everybody."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch

from sym2real.layout import Layout, Layouts
from sym2real.neural import ResidualMLP
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import Equations
from sym2real.tasks import Task, make_task

HORIZON = 40
GOALS = {"crazyflie": "hover", "mushr": "park"}


@dataclass(frozen=True)
class Subject:
    """One robot with the equations that everybody plans with.

    Args:
        robot: its sampling is white noise over 40 steps, which every library offers.
        equations: the fixed ones of ``reference_equations.json``.
        task: a constant goal.
        start: state that the plans begin from.
    """

    robot: Robot
    equations: Equations
    task: Task
    start: np.ndarray


def subject(name: str, file: Path) -> Subject:
    """A robot of the file with reference equations."""
    about = json.loads(file.read_text())[name]
    layouts = Layouts(Layout.of(about["state"]), Layout.of(about["action"]))
    equations = Equations.parse(layouts, about["next"], about["dt"], robot=name)
    robot = ROBOTS[name]
    white = replace(robot.mppi, horizon=HORIZON * robot.dt, knots=0, correlation=0.0)
    robot = replace(robot, mppi=white)
    start = torch.from_numpy(robot.start + 0.05 * np.random.default_rng(0).normal(size=robot.start.size))
    return Subject(robot, equations, make_task(GOALS[name], robot), robot.layouts.state.normalise(start).numpy())


def residual(robot: Robot, widths: tuple[int, ...], commands: int = 0) -> ResidualMLP:
    """A residual with random weights that sees so many past commands: only its cost matters here."""
    network = ResidualMLP(robot.layouts, widths, commands=commands)
    with torch.no_grad():
        network.linears[-1].weight.normal_(0.0, 0.1, generator=torch.Generator().manual_seed(0))
        network.output_scale.fill_(1e-3)
    return network
