"""Figures as files: measured against predicted, error over the horizon, the path that was flown or driven."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS, Comparison, Diagnosis, Floor, Tried
from sym2real.diagnosis.data.preparation import told_apart
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.files import safe_name
from sym2real.report.charts import Chart
from sym2real.report.horizons import comparison_charts, ladder_charts
from sym2real.report.html.added import curves
from sym2real.report.html.observed import observe
from sym2real.report.html.variants import Given, Predicting, Switch
from sym2real.report.style import LOOKS, MEASURED, REFERENCE, SERIES, grid, legend_below, logarithmic, save, small
from sym2real.trajectory import Trajectory

SIGNALS_A_ROW = 3
MOST_PREDICTED = 4  # logs that get a figure of their own


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


def comparison_figure(comparison: Comparison) -> Figure:
    """Error of every channel over the horizon, beside "hold", the mean and what the sensors' noise alone makes."""
    return charts_figure(comparison_charts(comparison))


def ladder_figure(stages: Sequence[Stage], floor: Sequence[Floor]) -> Figure:
    """Error of every channel over the horizon for every stage with its 95 % band, down to noise and disturbances."""
    return charts_figure(ladder_charts(stages, floor), "held-out error, one effect after the other")


def predictions_of(models: Mapping[str, Predicting], data: Dataset) -> dict[str, Figure]:
    """For every log that is long enough, by its name, every signal: measured, and predicted in pieces of 0.8 s.

    Those whose names as files would be one have their number ahead of it.

    Args:
        models: at most two, by what they are called.
        data: logs with the models' columns.
    """
    logs = [log for log in told_apart(data) if len(log) > ROWS]
    if not logs:
        return {}
    variants = Given(tuple(models.values()), tuple(Switch(name, "") for name in [*models][1:]))
    charts = curves(observe(variants, Dataset(logs))).charts
    names, files = ("measured", *models), [safe_name(log.name) for log in logs]
    figures = {}
    for place, log in enumerate(logs):
        own = [_of_log(chart, place, names) for chart in charts]
        title = f"{log.name}: measured, and predicted {JUDGED_AT:g} s ahead"
        alone = files.count(files[place]) == 1
        figures[log.name if alone else f"{place + 1}_{log.name}"] = charts_figure(own, title, beside=SIGNALS_A_ROW)
    return figures


def _of_log(chart: Chart, place: int, names: Sequence[str]) -> Chart:
    """A chart of one of its logs, its lines under these names."""
    pairs = zip(chart.lines, names, strict=True)
    lines = [replace(line, label=name, values=line.values[place]) for line, name in pairs]
    return replace(chart, along=chart.along[place], lines=lines)


def draw_comparison(model: Predicting, data: Dataset, comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures of a comparison; one of predictions for each of the first logs."""
    figures = {"error_over_horizon": comparison_figure(comparison)}
    return list(_save(figures | _predictions({"model": model}, data), folder))


def draw_found(
    models: Mapping[str, Predicting], data: Dataset, found: Diagnosis | Tried, folder: Path
) -> Iterator[Path]:
    """Write the figures of a diagnosis or of the test of an effect, one after the other.

    Args:
        models: the base and, where something was found, the informed model, by what they are called.
        data: logs without the faults that were found.
        found: its ladder and floor are drawn.
        folder: is made where it is missing.
    """
    figures = {"ladder": ladder_figure(found.ladder, found.floor)} if found.ladder else {}
    yield from _save(figures | _predictions(models, data), folder)


def _predictions(models: Mapping[str, Predicting], data: Dataset) -> dict[str, Figure]:
    predicted = predictions_of(models, Dataset(list(data)[:MOST_PREDICTED]))
    return {f"{name}_predicted": figure for name, figure in predicted.items()}


def _save(figures: Mapping[str, Figure], folder: Path) -> Iterator[Path]:
    for name, figure in figures.items():
        yield save(figure, folder, safe_name(name))
