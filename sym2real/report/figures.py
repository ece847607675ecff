"""Figures as files: measured against predicted, error over the horizon, the path that was flown or driven."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import torch
from matplotlib.figure import Figure

from sym2real.diagnosis import ROWS, Comparison, Windows, predict_windows
from sym2real.effects.visible import VisibleModel
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset, Trajectory

MEASURED, PREDICTED, REFERENCE = "#1b6ca8", "#d1495b", "#8d99ae"
WINDOWS_DRAWN = 12
PREDICTED_SECONDS = 0.8


def save(figure: Figure, path: Path) -> Path:
    """Write a figure beside, then rename; the format follows the file's ending."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{os.getpid()}-{path.name}")
    figure.savefig(beside, dpi=150, bbox_inches="tight")
    beside.replace(path)
    return path


def path_figure(trajectory: Trajectory) -> Figure:
    """The path seen from above, and every position and its reference over time."""
    columns = trajectory.layouts.state.field("position").columns
    figure = Figure(figsize=(10, 4.5), layout="constrained")
    above, over_time = figure.subplots(1, 2)
    above.plot(trajectory.column("x"), trajectory.column("y"), color=MEASURED, label="measured")
    if "ref_x" in trajectory.extra:
        above.plot(trajectory.extra["ref_x"], trajectory.extra["ref_y"], "--", color=REFERENCE, label="reference")
    above.set(xlabel="x in m", ylabel="y in m", title=trajectory.name, aspect="equal")
    above.legend()
    for column, style in zip(columns, ("-", "--", ":"), strict=False):
        over_time.plot(trajectory.time, trajectory.column(column), style, color=MEASURED, label=column)
        if f"ref_{column}" in trajectory.extra:
            over_time.plot(trajectory.time, trajectory.extra[f"ref_{column}"], style, color=REFERENCE)
    over_time.set(xlabel="time in s", ylabel="position in m")
    over_time.legend()
    return figure


def comparison_figure(comparison: Comparison) -> Figure:
    """Error of every channel over the horizon beside "hold"."""
    channels = comparison.one_step.errors
    points = [comparison.one_step, *comparison.horizons]
    figure = Figure(figsize=(3.4 * len(channels), 3.4), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, len(channels)))
    for axis, (channel, first) in zip(axes, channels.items(), strict=True):
        horizons = [errors.horizon for errors in points]
        axis.plot(horizons, [errors.errors[channel].value for errors in points], "o-", color=PREDICTED, label="model")
        axis.plot(horizons, [errors.errors[channel].hold for errors in points], "s--", color=REFERENCE, label="hold")
        axis.set(xlabel="horizon in s", ylabel=f"error in {first.unit}", title=channel, yscale="log")
        axis.legend()
    return figure


def prediction_figure(trajectory: Trajectory, windows: Windows) -> Figure:
    """Every state column over time: measured, and what the model predicted from a few starts along the log."""
    columns = trajectory.layouts.state.columns
    rows = -(-len(columns) // 3)
    figure = Figure(figsize=(12, 2.2 * rows), layout="constrained")
    axes = figure.subplots(rows, 3, squeeze=False).ravel()
    every = max(1, len(windows.rows) // WINDOWS_DRAWN)
    for position, (axis, column) in enumerate(zip(axes, columns, strict=False)):
        axis.plot(trajectory.time, trajectory.state[:, position], color=MEASURED, linewidth=1)
        for start, predicted in zip(windows.rows[::every], windows.predicted[::every], strict=True):
            ahead = trajectory.time[start : start + len(predicted) + 1]
            values = np.concatenate([trajectory.state[start : start + 1, position], predicted[:, position].numpy()])
            axis.plot(ahead, values, color=PREDICTED, linewidth=1)
        axis.set(title=f"{column} in {trajectory.layouts.state.units[column]}")
    for axis in axes[len(columns) :]:
        axis.set_visible(False)
    figure.suptitle(f"{trajectory.name}: measured (blue), predicted (red)")
    return figure


def draw_comparison(equations: Equations, data: Dataset, comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures of a comparison; one of predictions for every log."""
    model = VisibleModel(equations, dtype=torch.float64)
    paths = [save(comparison_figure(comparison), folder / "error_over_horizon.png")]
    for trajectory in data:
        steps = min(round(PREDICTED_SECONDS / trajectory.dt), len(trajectory) - ROWS)
        figure = prediction_figure(trajectory, predict_windows(model, trajectory, steps, comparison.start))
        paths.append(save(figure, folder / f"{trajectory.name}_predicted.png"))
    return paths
