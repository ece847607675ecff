"""What an episode showed: how well it was flown, and, in Stage I, predicted, and whether that still gets better."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from sym2real.robots import Robot
from sym2real.tasks import Task
from sym2real.tasks.cost import running_cost
from sym2real.trajectory import Array, Trajectory

# Settled: the newest episode was predicted about as well as those fitted, and flown about as well as the best.
SETTLED_PREDICTION = 2.0
SETTLED_TRACKING = 1.2
FEWEST_EPISODES = 3


@dataclass(frozen=True)
class EpisodeReport:
    """One episode of Stage I.

    Args:
        number: counted from 0.
        task: name of the task, "random commands" for the first.
        rows: of all its trajectories.
        crashes: how often it ended on the ground.
        tracking: mean position error, NaN for random commands.
        prediction: one-step error of the equations that flew it, relative to how far states move in a step
            (root mean square over state columns); NaN for the first.
        fitted: the same of the equations fitted afterwards, on all rows so far.
        seconds: time of the fit.
        unit: of the position error: m, of joints theirs.
    """

    number: int
    task: str
    rows: int
    crashes: int
    tracking: float
    prediction: float
    fitted: float
    seconds: float
    unit: str = "m"


def position_errors(trajectory: Trajectory) -> Array:
    """Distance from the reference, row by row: of the position in m, of joints in their units ``# (rows,)``."""
    columns = [column for field in trajectory.layouts.state.placing for column in field.columns]
    offsets = [trajectory.column(column) - trajectory.extra[f"ref_{column}"] for column in columns]
    distances: Array = np.sqrt(np.square(offsets).sum(axis=0))
    return distances


def tracking_error(trajectory: Trajectory) -> float:
    """Mean distance in m from the reference, the paper's performance metric."""
    return float(position_errors(trajectory).mean())


def episode_error(trajectory: Trajectory, robot: Robot, steps: int) -> float:
    """Mean distance in m from the reference over an episode of so many steps.

    Rows that a crash has cost count as the radius of the robot's workspace, so that ending early never looks good.
    """
    missing = max(0, steps - len(trajectory))
    total = position_errors(trajectory).sum() + missing * robot.limits.workspace
    return float(total / (len(trajectory) + missing))


def episode_cost(trajectory: Trajectory, task: Task, robot: Robot, steps: int) -> float:
    """Mean running cost of the task over an episode of so many steps; a missing row is the workspace's radius away."""
    cost, layouts = running_cost(task, trajectory.layouts), trajectory.layouts
    state, action = torch.as_tensor(trajectory.state[1:]), torch.as_tensor(trajectory.action[:-1])
    reference = task.reference(torch.as_tensor(robot.dt * np.arange(steps), dtype=torch.float64))
    lost = reference[len(trajectory) :].clone()
    lost[:, layouts.state.index(layouts.state.placing[0].columns[0])] += robot.limits.workspace
    rest = torch.as_tensor(robot.rest).expand(len(lost), -1)
    flown = cost(state, action, reference[1 : len(trajectory)])
    return float(torch.cat([flown, cost(lost, rest, reference[len(trajectory) :])]).mean())


def settled(reports: Sequence[EpisodeReport]) -> bool:
    """True when the newest episode was predicted like the fitted ones and flown like the best of its task."""
    newest = reports[-1]
    if len(reports) < FEWEST_EPISODES or newest.crashes:
        return False
    earlier = [report.tracking for report in reports[:-1] if report.task == newest.task and not report.crashes]
    return (
        bool(earlier)
        and newest.prediction < SETTLED_PREDICTION * newest.fitted
        and newest.tracking < SETTLED_TRACKING * min(earlier)
    )
