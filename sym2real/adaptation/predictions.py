"""How far a model's predictions are from logs: one step ahead, and at the end of a horizon."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Dataset
from sym2real.effects.along_logs import predicted_from, prepared
from sym2real.neural.model_folder import Model
from sym2real.trajectory import Array, Trajectory

STRIDE = 0.1  # s between the starts of predictions


def horizon_errors(model: Model, logs: Iterable[Trajectory], steps: int) -> Array:
    """Distance of predicted from measured positions, or joints, after some steps ``# (windows,)``; none of short logs.

    In m, of joints in their units.
    """
    errors = [np.empty(0)]
    for log in (log for log in logs if len(log) > steps):
        rows = np.arange(0, len(log) - steps, max(1, round(STRIDE / log.dt)))
        state = log.layouts.state
        position = state.indices(column for field in state.placing for column in field.columns)
        away = _away(model, log, rows, steps)
        errors.append(np.linalg.norm(away[:, position], axis=1))
    return np.concatenate(errors)


def one_step_error(model: Model, logs: Iterable[Trajectory]) -> float:
    """One-step prediction error relative to how far states move, root mean square over state columns."""
    long = [log for log in logs if len(log) > 1]
    if not long:
        return float("nan")
    wrong, moved = (
        np.concatenate([np.square(values) for values in parts]).mean(axis=0)
        for parts in (
            [_away(model, log, np.arange(len(log) - 1), 1) for log in long],
            [np.diff(log.state, axis=0) for log in long],
        )
    )
    return float(np.sqrt(np.mean(wrong[moved > 0] / moved[moved > 0])))


def _away(model: Model, log: Trajectory, rows: NDArray[np.int64], steps: int) -> Array:
    """Predicted less measured state some steps after rows of a log ``# (windows, state)``."""
    predicting, (ready,) = prepared(model, Dataset([log]))
    away: Array = predicted_from(predicting, ready, rows, steps)[:, -1].numpy() - log.state[rows + steps]
    return away
