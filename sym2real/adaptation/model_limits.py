"""Whether a model may be flown: what it predicts around recorded flights must be what the robot can do.

Commands are drawn as MPPI draws them, about those that were recorded; the model is rolled out over MPPI's horizon, or
the longest log where all are shorter, from recorded states. Rollouts in which the base does no better do not count:
they are the place's doing, not the model's. Nor do a few: what is not finite has no weight in MPPI.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from sym2real.control.noise import deviations, sample, smoothing
from sym2real.dataset import Dataset
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.generator import generator_of
from sym2real.neural.model_folder import Model
from sym2real.robots import Robot
from sym2real.trajectory import Array, Trajectory

ROLLOUTS = 512
TOLERATED = 0.05  # share of rollouts: at the edge of what was recorded any fit is off, and MPPI averages many


def beyond_limits(model: Model, base: Model, logs: Sequence[Trajectory], robot: Robot, seed: int) -> str:
    """Why a model must not be flown; empty where nothing speaks against it.

    Args:
        model: to be flown.
        base: that is known to be sound.
        logs: recorded; those that are longer than the rollouts give the starts.
        robot: gives limits and MPPI's sampling.
        seed: of the commands.
    """
    steps = min(round(robot.mppi.horizon / robot.dt), max(map(len, logs), default=0) - 1)
    if steps < 1:
        return "no log has two rows to check its predictions on"
    starts = [(log, row) for log in logs for row in range(len(log) - steps)]
    chosen = [starts[place] for place in np.linspace(0, len(starts) - 1, ROLLOUTS).astype(int)]
    noise = _noise(robot, steps, seed)
    predicted, start = _rolled_out(model, chosen, noise, robot)
    sound = _excesses(*_rolled_out(base, chosen, noise, robot), robot)
    for what, beyond in _excesses(predicted, start, robot).items():
        share = float((beyond & ~sound[what]).double().mean())
        if share > TOLERATED:
            return f"{share:.0%} of its predictions have a {what}"
    return ""


def _noise(robot: Robot, steps: int, seed: int) -> Tensor:
    """Of the commands, as MPPI draws it ``# (rollouts, steps, action)``."""
    spread = deviations(robot.mppi.noise, len(robot.layouts.action))
    return sample(ROLLOUTS, smoothing(steps, robot.dt, robot.mppi), spread, generator_of(seed))


def _rolled_out(
    model: Model, starts: Sequence[tuple[Trajectory, int]], noise: Tensor, robot: Robot
) -> tuple[Tensor, Tensor]:
    """Predictions ``# (rollouts, steps, state)`` from rows of logs, and the states that they start from."""
    steps, low, high = noise.shape[1], torch.as_tensor(robot.low), torch.as_tensor(robot.high)
    predicted, begun, drawn = list[Tensor](), list[Array](), 0
    for log in dict.fromkeys(log for log, _ in starts):
        rows = np.array([row for other, row in starts if other is log])
        predicting, (ready,) = prepared(model, Dataset([log]))
        command = torch.as_tensor(ready.action[rows[:, None] + np.arange(steps)]) + noise[drawn : drawn + len(rows)]
        drawn += len(rows)
        predicted.append(predicted_from(predicting, ready, rows, steps, action=torch.clamp(command, low, high)))
        begun.append(log.state[rows])
    return torch.cat(predicted), torch.as_tensor(np.concatenate(begun))


def _excesses(predicted: Tensor, start: Tensor, robot: Robot) -> dict[str, Tensor]:
    """What is beyond the robot's limits in each rollout, by what it is ``# (rollouts,)``."""
    layout, limits = robot.layouts.state, robot.limits.state
    excesses = {
        f"{name} above {limit:.3g} {layout.field(name).unit}": _largest(predicted[..., layout.slice(name)]) > limit
        for name, limit in limits.items()
    }
    excesses = {"value that is not finite": ~predicted.isfinite().flatten(1).all(dim=1), **excesses}
    if layout.has_field("position") and "velocity" in limits:
        gone = _largest(predicted[..., layout.slice("position")] - start[:, None, layout.slice("position")])
        reach = limits["velocity"] * robot.dt * predicted.shape[1]
        excesses[f"position more than {reach:.3g} m from the start"] = gone > reach
    return excesses


def _largest(values: Tensor) -> Tensor:
    largest: Tensor = torch.linalg.vector_norm(values, dim=-1).amax(dim=-1)
    return largest
