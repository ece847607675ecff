"""An experiment's table for the terminal, and its figure in the paper's layout: one panel a case."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.table import Table

from sym2real.experiments.study.outcome import Outcome, Panel
from sym2real.report.style import SERIES, grid, legend_below, logarithmic
from sym2real.report.tables import compact_table

PANELS_A_ROW = 3
WIDTH = 48  # characters of a statement below a panel


def outcome_table(outcome: Outcome) -> Table:
    """The rows of an experiment; notes stand below."""
    table = compact_table(outcome.title, *outcome.columns, left=outcome.columns[:2])
    for row in outcome.rows:
        table.add_row(*row)
    return table


def outcome_figure(outcome: Outcome) -> Figure:
    """A panel for every case: mean and standard deviation over seeds, MuJoCo's own level, the paper's statement."""
    figure, axes = grid(len(outcome.panels), PANELS_A_ROW, 4.2, 3.6)
    names = list(dict.fromkeys(name for panel in outcome.panels for name in panel.lines))
    colours = dict(zip(names, SERIES * math.ceil(len(names) / len(SERIES)), strict=False))
    for axis, panel in zip(axes, outcome.panels, strict=True):
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
