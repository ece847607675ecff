"""Figures as files: measured against predicted, error over the horizon, the path that was flown or driven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS, Comparison, Floor, Windows, predict_windows
from sym2real.diagnosis.data.preparation import prepared
from sym2real.diagnosis.data.start import Start
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.protocols import DynamicsModel
from sym2real.report.charts import Chart
from sym2real.report.horizons import comparison_charts, ladder_charts
from sym2real.report.style import LOOKS, MEASURED, MODELS, REFERENCE, SERIES, grid, legend_below, logarithmic, small
from sym2real.symbolic import Equations
from sym2real.trajectory import Array, Trajectory

WINDOWS_DRAWN = 12


def path_figure(trajectory: Trajectory) -> Figure:
    """The path seen from above where there is one, and every position, or joint, and its reference over time."""
    placing = trajectory.layouts.state.placing
    columns, units = (
        [name for field in placing for name in field.columns],
        dict.fromkeys(field.unit for field in placing),
    )
    plane = all(column in trajectory.layouts.state for column in ("x", "y"))
    figure = Figure(figsize=(10, 4.5), layout="constrained")
    *above, over_time = figure.subplots(1, 2 if plane else 1, squeeze=False)[0]
    for axis in above:
        _from_above(axis, trajectory)
    for column, style in zip(columns, cycle(("-", "--", ":")), strict=False):
        over_time.plot(trajectory.time, trajectory.column(column), style, color=MEASURED, label=column)
        if f"ref_{column}" in trajectory.extra:
            over_time.plot(
                trajectory.time, trajectory.extra[f"ref_{column}"], style, color=REFERENCE, label="reference"
            )
    over_time.set(xlabel="time in s", ylabel=f"position in {', '.join(units)}")
    legend_below(figure)
    return figure


def _from_above(above: Axes, trajectory: Trajectory) -> None:
    above.plot(trajectory.column("x"), trajectory.column("y"), color=MEASURED, label="measured")
    if "ref_x" in trajectory.extra:
        above.plot(trajectory.extra["ref_x"], trajectory.extra["ref_y"], "--", color=REFERENCE, label="reference")
    above.set(xlabel="x in m", ylabel="y in m", aspect="equal")
    above.set_title(trajectory.name, parse_math=False)


def charts_figure(charts: Sequence[Chart], title: str = "", *, beside: int | None = None) -> Figure:
    """Charts on logarithmic axes, so many beside each other, all by default; lines show what holds without switches."""
    figure, axes = grid(len(charts), beside or len(charts), 3.6, 3.1)
    for axis, chart in zip(axes, charts, strict=True):
        for line in chart.lines:
            along = np.asarray(chart.along if line.x is None else line.x)
            look = LOOKS[line.role] if isinstance(line.role, str) else {"color": SERIES[line.role % len(SERIES)]}
            axis.plot(along, np.asarray(line.values), **{"marker": "o", **look}, label=line.label)
            if line.low is not None and line.high is not None:
                band = np.asarray(line.low), np.asarray(line.high)
                axis.fill_between(along, *band, color=look["color"], alpha=0.15, linewidth=0)
        axis.set(xlabel=chart.x, ylabel=chart.y, title=chart.title)
        logarithmic(axis)
    legend_below(figure)
    if title:
        figure.suptitle(title)
    return figure


def comparison_figure(comparison: Comparison) -> Figure:
    """Error of every channel over the horizon, beside "hold", the mean and what the sensors' noise alone makes."""
    return charts_figure(comparison_charts(comparison))


def ladder_figure(stages: Sequence[Stage], floor: Sequence[Floor]) -> Figure:
    """Error of every channel over the horizon for every stage with its 95 % band, down to noise and disturbances."""
    return charts_figure(ladder_charts(stages, floor), "held-out error, one effect after the other")


def prediction_figure(trajectory: Trajectory, windows: dict[str, Windows]) -> Figure:
    """Every state column over time: measured, and what models predicted from a few starts along the log.

    Args:
        trajectory: the log.
        windows: predictions by what the model is called: at most two.
    """
    columns = trajectory.layouts.state.columns
    figure, axes = grid(len(columns), 3, 3.4, 2.0)
    for position, (axis, column) in enumerate(zip(axes, columns, strict=True)):
        axis.plot(trajectory.time, trajectory.state[:, position], color=MEASURED, linewidth=1, label="measured")
        for style, (label, predictions) in zip(MODELS, windows.items(), strict=False):
            times, values = _pieces(trajectory, predictions, position)
            axis.plot(times, values, **style, linewidth=1.2, label=label)
        axis.set(title=f"{column} in {trajectory.layouts.state.units[column]}")
    small(axes)
    legend_below(figure)
    figure.suptitle(f"{trajectory.name}: measured, and predicted {JUDGED_AT:g} s ahead", parse_math=False)
    return figure


def _pieces(trajectory: Trajectory, predictions: Windows, position: int) -> tuple[Array, Array]:
    """Times and values of a few predictions along a log, each from its measured start, as one line with gaps."""
    every = max(1, len(predictions.rows) // WINDOWS_DRAWN)
    times, values = list[ArrayLike](), list[ArrayLike]()
    for start, predicted in zip(predictions.rows[::every], predictions.predicted[::every], strict=True):
        times += [trajectory.time[start : start + len(predicted) + 1], [np.nan]]
        values += [trajectory.state[start : start + 1, position], predicted[:, position].numpy(), [np.nan]]
    return np.concatenate(times), np.concatenate(values)


def predictions_of(
    models: Mapping[str, Equations | DynamicsModel], data: Dataset, start: Start = "smoothed"
) -> dict[str, Figure]:
    """One figure of predictions for every log that is long enough, by its name.

    Args:
        models: at most two, by what they are called.
        data: logs with the models' columns.
        start: how start states are found.
    """
    prepared_models = {label: prepared(equations, data) for label, equations in models.items()}
    figures = {}
    for index, trajectory in enumerate(data):
        steps = min(round(JUDGED_AT / trajectory.dt), len(trajectory) - ROWS)
        if steps < 1:
            continue
        windows = {
            label: predict_windows(predictor, logs[index], steps, start)
            for label, (predictor, logs) in prepared_models.items()
        }
        figures[trajectory.name] = prediction_figure(trajectory, windows)
    return figures
