"""Prediction windows along a log: start state, what was sent, what was known, what came out."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset, logs_in
from sym2real.diagnosis.data.preparation import without_stops
from sym2real.diagnosis.data.start import ROWS, Start, start_states
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.errors import ShapeError
from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import JOINT_ANGLE, JOINT_DISPLACEMENT

# How an error is measured (docs/method.md): windows start every so many s, and end after these.
STRIDE = 0.1
HORIZONS = (0.1, 0.2, 0.5, 0.8, 1.0)
# Error of a prediction that is no number; its square is one.
LARGEST = float(np.finfo(np.float32).max)
# The horizon (s) that a finding is judged at: about as long as a controller's.
JUDGED_AT = 0.8
# Channels by which predictions are judged: what a user sees, and what logs do not have by differencing.
JUDGED = ("position", "attitude", "yaw", JOINT_DISPLACEMENT.name, JOINT_ANGLE.name)

UNIT_OF_KIND = {"quaternion": "rad", "circle": "rad"}


def horizons_in_rows(dt: float) -> list[float]:
    """Those of :data:`HORIZONS` (s) that are whole rows of ``dt`` s, or nearly so."""
    missed = {horizon: abs(max(1, round(horizon / dt)) * dt - horizon) for horizon in HORIZONS}
    return [horizon for horizon, by in missed.items() if by <= SETTINGS.worth_saying * horizon]


def rows_ahead(horizon: float, dt: float) -> int:
    """How many rows of ``dt`` s a horizon (s) is long.

    Raises:
        ShapeError: when it is none.
    """
    rows = round(horizon / dt) if isfinite(horizon) else 0
    if rows < 1:
        raise ShapeError(f"expected a horizon of at least one time step, {dt:.4g} s, found {horizon:g} s")
    return rows


def stride_of(dt: float) -> int:
    """Rows of ``dt`` s between the starts of windows."""
    return max(1, round(STRIDE / dt))


@dataclass(frozen=True, eq=False)
class Windows:
    """Predictions over windows of one length, all starting where a start state can be estimated.

    Args:
        rows: row at which each window starts ``# (windows,)``.
        predicted: not a number behind where the model diverges ``# (windows, steps, state)``.
        measured: ``# (windows, steps, state)``.
        start: the start states, which "hold" keeps for ever ``# (windows, state)``.
        layout: the state's columns.
    """

    rows: NDArray[np.int64]
    predicted: Tensor
    measured: Tensor
    start: Tensor
    layout: Layout

    @property
    def missed(self) -> Tensor:
        """What came out after one step, less what was predicted ``# (windows, tangent)``."""
        return self.layout.difference(self.measured[:, 0], self.predicted[:, 0])


def free_run_seconds(layout: Layout) -> float:
    """How long a free run is, s: a car drifts slowly, a quadrotor with a wrong model is upside down after two."""
    return 5.0 if layout.has_field("heading") else 2.0


def judged(channels: Iterable[str]) -> list[str]:
    """Those of some channels that predictions are judged by; all of them where none of the usual ones is there."""
    channels = list(channels)
    return [channel for channel in JUDGED if channel in channels] or channels


def channel_name(field: Field) -> str:
    """What reports call a field: its name, but "yaw" for a heading on the circle."""
    return "yaw" if field.name == "heading" else field.name


def channel_units(layout: Layout) -> dict[str, str]:
    """Unit of every channel's error; rotations are counted in rad."""
    return {channel_name(field): UNIT_OF_KIND.get(field.kind, field.unit) for field in layout.fields}


def channel_errors(layout: Layout, predicted: Tensor, measured: Tensor) -> dict[str, Array]:
    """Norm of the difference per field, on the manifold ``# (...)``."""
    parts = layout.difference(predicted, measured).split([field.tangent_size for field in layout.fields], dim=-1)
    return {channel_name(field): part.norm(dim=-1).numpy() for field, part in zip(layout.fields, parts, strict=True)}


def finite_errors(layout: Layout, predicted: Tensor, measured: Tensor) -> dict[str, Array]:
    """The same, and a large number where a model diverges: not a number would be neither larger nor smaller."""
    return {name: np.fmin(values, LARGEST) for name, values in channel_errors(layout, predicted, measured).items()}


def predict_windows(
    model: DynamicsModel, trajectory: Trajectory, steps: int, start: Start = "smoothed", stride: int | None = None
) -> Windows:
    """Predict ``steps`` rows ahead from every start along a log.

    Args:
        model: as :func:`~sym2real.effects.along_logs.predicted_from` takes it.
        trajectory: the log, its columns those of the model.
        steps: length of a window in rows.
        start: how the start state is found (:mod:`sym2real.diagnosis.data.start`).
        stride: rows between starts; every :data:`STRIDE` s by default.

    Raises:
        ShapeError: when the log is too short for one window.
    """
    stride = stride or stride_of(trajectory.dt)
    rows = without_stops(trajectory, np.arange(ROWS - 1, len(trajectory) - steps, stride), steps + 1)
    if not len(rows):
        raise ShapeError(
            f"trajectory {trajectory.name!r} has {len(trajectory)} rows; "
            f"a window of {steps} steps after {ROWS} rows of history needs {ROWS + steps}"
        )
    state = start_states(trajectory, rows, start)
    predicted = predicted_from(model, trajectory, rows, steps, start=state)
    # What single precision does not hold is no number: squares of all others are numbers.
    predicted = torch.where(predicted.float().isfinite(), predicted, torch.nan)
    measured = torch.as_tensor(trajectory.state[rows[:, None] + np.arange(1, steps + 1)])
    return Windows(rows, predicted, measured, torch.as_tensor(state), trajectory.layouts.state)


def one_step_windows(model: DynamicsModel, trajectory: Trajectory) -> Windows:
    """Predict one row ahead from every measured row that has a history."""
    return predict_windows(model, trajectory, 1, "measured", stride=1)


def simulate(whole: Equations | DynamicsModel, log: Trajectory, horizon: float | None = None) -> Trajectory:
    """See :meth:`~sym2real.Equations.simulate`."""
    model, logs = prepared(whole, Dataset(logs_in(log)))
    ready = logs[0]
    steps = len(ready) - 1 if horizon is None else rows_ahead(horizon, ready.dt)
    rows = np.arange(0, len(ready) - 1, steps)
    predicted = predicted_from(model, ready, rows, steps, start=start_states(ready, rows)).flatten(0, 1).numpy()
    state = np.concatenate([ready.state[:1], predicted[: len(ready) - 1]])
    layouts = replace(ready.layouts, action=log.layouts.action)
    return replace(ready, state=state, action=log.action, layouts=layouts, name=f"{log.name} simulated".strip(), raw={})
