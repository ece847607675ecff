"""What a model predicts, as its methods: one step, a log, and how well."""

from typing import TypeVar

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from sym2real.dataset import Logs
from sym2real.errors import ShapeError
from sym2real.trajectory import Array, Trajectory
from sym2real.upward import upward

Values = TypeVar("Values", Array, Tensor)


def tensor_of(values: ArrayLike) -> Tensor:
    """Numbers as a tensor of float64.

    Raises:
        ShapeError: for what holds none, such as the path of a log.
    """
    try:
        return torch.as_tensor(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        expected = "expected arrays of states and actions (simulate and score take whole logs)"
        raise ShapeError(f"{expected}, found {values!r:.80}") from None


class Predicting:
    """Methods of equations, and of models with networks; NumPy in, NumPy out, tensors in, tensors out."""

    def predict(self, state: Values, action: Values, inputs: Values | None = None) -> Values:
        """State one time step later, as sensors report it; leading dimensions broadcast.

        Delays and lags of commands are not in it, as they need the commands before: see :meth:`simulate`. A network
        that sees past rows takes this one for all of them.

        Args:
            state: measured state in the columns' units, without hidden columns ``# (..., state)``.
            action: ``# (..., action)``.
            inputs: known inputs; zero by default ``# (..., inputs)``.

        Returns:
            The next state ``# (..., state)``: NumPy in float64 for NumPy, a tensor for tensors.

        Raises:
            ShapeError: for other columns, naming them.
        """
        return upward("predict")(self, state, action, inputs)

    def simulate(self, log: Trajectory, horizon: float | None = None) -> Trajectory:
        """The log as the model predicts it from its commands and inputs, with all its effects.

        Args:
            log: its columns and time step are those of the model.
            horizon: s after which the prediction starts again from the log; None for one free run from the first row.

        Raises:
            ShapeError: when columns or time steps differ, or the horizon is no step long.

        Examples:
            >>> robot = ROBOTS["mushr"]
            >>> model, task = robot.nominal(), make_task("circle", robot)
            >>> log = run_episode(MujocoPlant(robot), MPPI(compile_model(model), robot, task), task, steps=60)
            >>> error = model.simulate(log, horizon=0.5).column("x") - log.column("x")
            >>> float(np.abs(error).max()) < 0.05
            True
        """
        return upward("simulate")(self, log, horizon)

    def score(self, log: Logs, horizon: float = 0.5) -> dict[str, float]:
        """Fit of predictions in % by channel, 100·(1 − RMSE/standard deviation) as MATLAB's ``compare`` counts.

        100 is perfect, 0 no better than the mean of the log; not a number where a log is too short to tell.

        Args:
            log: one or more, with the model's columns and time step.
            horizon: how far ahead, s; predictions start every 0.1 s.

        Raises:
            ShapeError: when columns or time steps differ, or no log is long enough.
        """
        return upward("score")(self, log, horizon)
