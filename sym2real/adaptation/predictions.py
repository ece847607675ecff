"""How far a model's predictions are from logs: one step ahead, and at the end of a horizon."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sym2real.dataset import Dataset
from sym2real.effects.along_logs import in_columns_of, predicted_from, prepared
from sym2real.neural.model_folder import Model
from sym2real.trajectory import Array, Trajectory

STRIDE = 0.1  # s between the starts of predictions


def horizon_errors(model: Model, logs: Iterable[Trajectory], steps: int) -> Array:
    """Distance of predicted from measured positions, or joints, after some steps ``# (windows, fields)``.

    In m, of joints in their units; a field of the state that says where the robot is has a column. None of short logs.
    """
    errors = []
    for log in (in_columns_of(model, log) for log in logs):
        rows = np.arange(0, len(log) - steps, max(1, round(STRIDE / log.dt))) if len(log) > steps else np.arange(0)
        state = log.layouts.state
        away = _away(model, log, rows, steps) if len(rows) else np.empty((0, state.size))
        errors.append([np.linalg.norm(away[:, state.slice(field.name)], axis=1) for field in state.placing])
    return np.concatenate(errors, axis=1).T


def in_shares(errors: Array, of: Array) -> Array:
    """Errors of several fields as one ``# (windows,)``: the mean of their shares of another model's mean errors.

    A crane's rail in m and its sway in rad count alike, whichever number is larger; one field keeps its proportions.

    Args:
        errors: of a model ``# (windows, fields)``.
        of: of the model that it is held against, on the same windows ``# (windows, fields)``.
    """
    size = of.mean(axis=0) if len(of) else np.empty(0)
    shares: Array = (errors[:, size > 0] / size[size > 0]).mean(axis=1) if (size > 0).any() else errors.sum(axis=1)
    return shares


def one_step_error(model: Model, logs: Iterable[Trajectory]) -> float:
    """One-step prediction error relative to how far states move, root mean square over state columns."""
    long = [in_columns_of(model, log) for log in logs if len(log) > 1]
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
    """Predicted less measured state some steps after rows of a log in the model's columns ``# (windows, state)``."""
    predicting, (ready,) = prepared(model, Dataset([log]))
    return predicted_from(predicting, ready, rows, steps)[:, -1].numpy() - log.state[rows + steps]
