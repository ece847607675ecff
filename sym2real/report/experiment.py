"""An experiment's table for the terminal, and its figure in the paper's layout: one panel a case."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich import box
from rich.table import Table

from sym2real.experiments.study.outcome import Outcome, Panel
from sym2real.report.style import SERIES, legend_below, logarithmic

PANELS_A_ROW = 3
WIDTH = 48  # characters of a statement below a panel


def outcome_table(outcome: Outcome) -> Table:
    """The rows of an experiment; notes stand below."""
    table = Table(title=outcome.title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for place, heading in enumerate(outcome.columns):
        table.add_column(heading, justify="left" if place < 2 else "right", overflow="fold")
    for row in outcome.rows:
        table.add_row(*row)
    return table


def outcome_figure(outcome: Outcome) -> Figure:
    """A panel for every case: mean and standard deviation over seeds, MuJoCo's own level, the paper's statement."""
    across = min(PANELS_A_ROW, len(outcome.panels))
    down = math.ceil(len(outcome.panels) / across)
    figure = Figure(figsize=(4.2 * across, 3.6 * down + 0.5), layout="constrained")
    axes = np.ravel(figure.subplots(down, across, squeeze=False))
    names = list(dict.fromkeys(name for panel in outcome.panels for name in panel.lines))
    colours = dict(zip(names, SERIES * math.ceil(len(names) / len(SERIES)), strict=False))
    for axis in axes[len(outcome.panels) :]:
        axis.set_visible(False)
    for axis, panel in zip(axes, outcome.panels, strict=False):
        _draw(axis, panel, outcome, colours)
    legend_below(figure)
    return figure


def _draw(axis: Any, panel: Panel, outcome: Outcome, colours: dict[str, str]) -> None:
    for name, line in panel.lines.items():
        axis.plot(line.x, line.mean, "o-", markersize=3, color=colours[name], label=name)
        low, high = np.maximum(line.mean - line.spread, 0.2 * line.mean), line.mean + line.spread
        axis.fill_between(line.x, low, high, color=colours[name], alpha=0.15, linewidth=0)
    if panel.level is not None:
        axis.axhline(panel.level, color="black", linestyle="--", linewidth=1, label="MPPI with MuJoCo itself")
    quotation = textwrap.fill(f"Paper: {panel.paper}", WIDTH) if panel.paper else ""
    axis.set(ylabel=outcome.y, title=panel.title)
    logarithmic(axis)
    axis.set_xlabel(f"{outcome.x}\n{quotation}" if quotation else outcome.x, fontsize=8)
