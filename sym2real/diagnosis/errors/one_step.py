"""One-step residuals of a model along logs, row by row, and their correlations over lags."""

from collections.abc import Collection, Sequence

import numpy as np

from sym2real import correlations
from sym2real.dataset import Dataset
from sym2real.diagnosis.data.start import ROWS
from sym2real.diagnosis.data.windows import UNIT_OF_KIND, channel_name, one_step_windows
from sym2real.diagnosis.errors.residuals import Following, Residual, Residuals
from sym2real.effects.along_logs import prepared
from sym2real.layout import Layout
from sym2real.logs.noise import SMALLEST_NOISE
from sym2real.protocols import DynamicsModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Array

MEMORY = 0.5  # s: longest lag
PIECE = 4  # the longest lag is at most this part of the longest log


def one_step_residuals(model: Equations | DynamicsModel, data: Dataset, constant: Collection[str] = ()) -> Residuals:
    """Autocorrelation of what one-step predictions miss, and its correlation with what was sent.

    Args:
        model: predicts in float64, with the data's columns.
        data: logs; those shorter than a window's history and a few rows are left out.
        constant: commands that hardly vary, which are left out.

    Raises:
        ShapeError: when columns or time steps differ.
    """
    predictor, dataset = prepared(model, data)
    misses, sent = [], []
    for trajectory, as_sent in zip(dataset, data, strict=True):
        if len(trajectory) > ROWS + PIECE:
            windows = one_step_windows(predictor, trajectory)
            misses.append(windows.missed.numpy())
            sent.append(as_sent.action[windows.rows])
    if not misses:
        return Residuals(dataset.dt, 0, 0, {})
    lags = max(1, min(round(MEMORY / dataset.dt), max(map(len, misses)) // PIECE))
    commands = {
        name: correlations.centred([rows[:, place] for rows in sent])
        for place, name in enumerate(data.layouts.action)
        if name not in constant
    }
    residuals = {
        name: residual_of(correlations.centred([rows[:, place] for rows in misses]), commands, lags, unit)
        for place, (name, unit) in enumerate(tangent_units(dataset.layouts.state).items())
    }
    components = {name: residual for name, residual in residuals.items() if residual is not None}
    return Residuals(dataset.dt, sum(map(len, misses)), lags, components)


def residual_of(pieces: Sequence[Array], commands: dict[str, list[Array]], lags: int, unit: str) -> Residual | None:
    """Correlations of one component; None where the model predicts it to the last digit.

    Args:
        pieces: its residuals by log, centred ``# (rows,)`` each.
        commands: by name, centred, in the same pieces.
        lags: longest lag in rows.
        unit: of the residual.
    """
    rows = sum(map(len, pieces))
    deviation = float(np.sqrt(sum(float(piece @ piece) for piece in pieces) / rows))
    if deviation <= SMALLEST_NOISE:
        return None
    far = max(lags, correlations.summed_lags(pieces))
    itself = correlations.autocorrelation(pieces, far)
    following = {
        name: Following(
            correlations.cross_correlations(pieces, values, lags),
            correlations.cross_deviation(rows, itself, correlations.autocorrelation(values, far)),
        )
        for name, values in commands.items()
    }
    return Residual(deviation, unit, itself[:lags], correlations.own_deviations(rows, itself[:lags]), following)


def tangent_units(layout: Layout) -> dict[str, str]:
    """Name and unit of every component of a difference between states, in their order."""
    units: dict[str, str] = {}
    for field in layout.fields:
        names = field.columns
        if field.kind != "vector":
            axes = "xyz"[: field.tangent_size]
            names = tuple(f"{channel_name(field)} {axis}" for axis in axes) if len(axes) > 1 else (channel_name(field),)
        units |= dict.fromkeys(names, UNIT_OF_KIND.get(field.kind, field.unit))
    return units
