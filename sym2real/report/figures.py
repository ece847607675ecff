"""Figures of matplotlib: measured against predicted, error over the horizon, the path that was flown or driven."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.charts import Chart
from sym2real.report.html.added import curves
from sym2real.report.html.observed import observe
from sym2real.report.html.variants import Given, Predicting, Switch
from sym2real.report.style import LOOKS, MEASURED, REFERENCE, SERIES, grid, legend_below, logarithmic, small
from sym2real.trajectory import Trajectory

SIGNALS_A_ROW = 3


def path_figure(trajectory: Trajectory) -> Figure:
    """The path seen from above where there is one, and every position, or joint, and its reference over time."""
    placing = trajectory.layouts.state.placing
    columns = [name for field in placing for name in field.columns]
    units = dict.fromkeys(field.unit for field in placing)
    plane = all(column in trajectory.layouts.state for column in ("x", "y"))
    figure = Figure(figsize=(10, 4.5), layout="constrained")
    *above, over_time = figure.subplots(1, 2 if plane else 1, squeeze=False)[0]
    for axis in above:
        axis.plot(trajectory.column("x"), trajectory.column("y"), color=MEASURED, label="measured")
        if "ref_x" in trajectory.extra:
            axis.plot(trajectory.extra["ref_x"], trajectory.extra["ref_y"], "--", color=REFERENCE, label="reference")
        axis.set(xlabel="x in m", ylabel="y in m", aspect="equal")
        axis.set_title(trajectory.name, parse_math=False)
    for column, style in zip(columns, cycle(("-", "--", ":")), strict=False):
        over_time.plot(trajectory.time, trajectory.column(column), style, color=MEASURED, label=column)
        if f"ref_{column}" in trajectory.extra:
            over_time.plot(
                trajectory.time, trajectory.extra[f"ref_{column}"], style, color=REFERENCE, label="reference"
            )
    over_time.set(xlabel="time in s", ylabel=f"position in {', '.join(units)}")
    legend_below(figure)
    return figure


def charts_figure(charts: Sequence[Chart], title: str = "", *, beside: int | None = None) -> Figure:
    """Charts beside each other, errors on logarithmic axes; lines show what holds with all switches or without.

    Args:
        charts: of lines of numbers; those over time get little room each, as there are many.
        title: of the whole.
        beside: how many stand in a row; all by default.
    """
    over_time = charts[0].kind == "time"
    figure, axes = grid(len(charts), beside or len(charts), *((3.4, 2.0) if over_time else (3.6, 3.1)))
    for axis, chart in zip(axes, charts, strict=True):
        for line in chart.lines:
            along = np.asarray(chart.along if line.x is None else line.x)
            look = LOOKS[line.role] if isinstance(line.role, str) else {"color": SERIES[line.role % len(SERIES)]}
            values = np.atleast_2d(np.asarray(line.values))[-1 if line.switched else 0]
            axis.plot(along, values, **{"marker": "o" if chart.points else "", **look}, label=line.label)
            if line.low is not None and line.high is not None:
                band = np.asarray(line.low), np.asarray(line.high)
                axis.fill_between(along, *band, color=look["color"], alpha=0.15, linewidth=0)
        if over_time:
            axis.set(title=chart.y)
        else:
            axis.set(xlabel=chart.x, ylabel=chart.y, title=chart.title)
            logarithmic(axis)
    if over_time:
        small(axes)
    legend_below(figure)
    if title:
        figure.suptitle(title, parse_math=False)
    return figure


def predictions_figure(models: Mapping[str, Predicting], log: Trajectory) -> Figure:
    """Every signal of a log: measured, and predicted in pieces of 0.8 s by one or two models, by their names."""
    variants = Given(tuple(models.values()), tuple(Switch(name, "") for name in [*models][1:]))
    charts = [_named(chart, ("measured", *models)) for chart in curves(observe(variants, Dataset([log]))).charts]
    title = f"{log.name}: measured, and predicted {JUDGED_AT:g} s ahead"
    return charts_figure(charts, title, beside=SIGNALS_A_ROW)


def _named(chart: Chart, names: Sequence[str]) -> Chart:
    """A chart of a single log, its lines under these names."""
    pairs = zip(chart.lines, names, strict=True)
    lines = [replace(line, label=name, values=line.values[0]) for line, name in pairs]
    return replace(chart, along=chart.along[0], lines=lines)
