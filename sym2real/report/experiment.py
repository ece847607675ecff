"""An experiment's table for the terminal, and its figure in the paper's layout: one panel a case."""

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from rich.markup import escape
from rich.table import Table

from sym2real.experiments.study.outcome import Outcome, Panel
from sym2real.report.charts import Chart, Line
from sym2real.report.figures import charts_figure
from sym2real.report.tables import compact_table

PANELS_A_ROW = 3
WIDTH = 48  # characters of a statement below a panel


def outcome_table(outcome: Outcome) -> Table:
    """The rows of an experiment; notes stand below."""
    rows = [list(map(escape, row)) for row in outcome.rows]  # titles are those of somebody's file
    return compact_table(escape(outcome.title), outcome.columns, rows, left=outcome.columns[:2])


def outcome_figure(outcome: Outcome) -> Figure:
    """A panel for every case: mean and standard deviation over seeds, MuJoCo's own level, the paper's statement."""
    names = list(dict.fromkeys(name for panel in outcome.panels for name in panel.lines))
    figure = charts_figure([_chart(panel, outcome, names) for panel in outcome.panels], beside=PANELS_A_ROW)
    for axis in figure.axes:
        axis.xaxis.label.set_fontsize(8)
    return figure


def _chart(panel: Panel, outcome: Outcome, names: Sequence[str]) -> Chart:
    lines = []
    for name, line in panel.lines.items():
        low, high = np.maximum(line.mean - line.spread, 0.2 * line.mean), line.mean + line.spread
        lines.append(Line(name, names.index(name), line.mean, low, high, line.x))
    longest = max((line.x for line in panel.lines.values()), key=len)
    if panel.level is not None:
        lines.append(Line("MPPI with MuJoCo itself", "floor", np.full(len(longest), panel.level)))
    quotation = textwrap.fill(f"Paper: {panel.paper}", WIDTH) if panel.paper else ""
    return Chart(panel.title, "", f"{outcome.x}\n{quotation}".strip(), outcome.y, longest, lines, points=True)
