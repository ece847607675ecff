"""What an adaptation has led to: a table for the terminal, and the errors of every round as a figure."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from rich.console import Group
from rich.table import Table
from rich.text import Text

from sym2real.adaptation import Improvement, RoundReport
from sym2real.adaptation.round_report import best_of, settled
from sym2real.report.charts import Chart, Line
from sym2real.report.figures import charts_figure
from sym2real.report.tables import compact_table, number


def rounds_report(reports: Sequence[RoundReport]) -> Group:
    """One row per round, and what the figures mean."""
    ahead, best = f"{reports[0].horizon:.3g} s", reports[best_of(reports)]
    lines = [
        f"error: mean distance from the reference; {ahead}: error of the position predicted that far ahead, on the "
        "round's own log, which its model has not seen",
        "% better: than the best model before, with its 95 % interval, row by row and on the same log; joints in m and "
        "joints in rad count alike",
        "rows: learned from; cost: mean running cost of the task; λ: weight of the residual's size; s: of the training",
        "kept: what was learned is not used; crash: the episode ended early",
        f"on top, where verbs open it: the model of round {best.number}",
    ]
    lines += [
        f"round {entry.number}: kept the model before: {entry.learned.refused}" for entry in reports if _refused(entry)
    ]
    crashed = all(entry.crashed for entry in reports)
    lines += ["every episode ended in a crash: such short logs teach little, and no round is surely better"] * crashed
    effects = best.learned.effects
    lines += [f"effects in the equations: {', '.join(effects)}"] if effects else []
    what = "position error" if reports[0].flown else "prediction"
    lines += [f"two rounds in a row have not improved the {what} beyond its interval"] if settled(reports) else []
    return Group(rounds_table(reports), *(Text(line) for line in lines))


def _refused(report: RoundReport) -> bool:
    return bool(report.learned.refused)


def rounds_table(reports: Sequence[RoundReport]) -> Table:
    """Figures of every round; the last cell says which model is on top, what crashed, and what was not used."""
    best, unit = best_of(reports), reports[0].unit
    ahead = f"{reports[0].horizon:.3g} s {unit}"
    headings = ("round", "rows", f"error {unit}", "% better", "cost", ahead, "% better", "λ", "s", "")
    rows = [
        (
            str(report.number),
            str(report.learned.rows),
            number(report.error),
            _percent(report.tracking),
            number(report.cost),
            number(report.prediction, 2),
            _percent(report.gain),
            number(report.learned.penalty, 1),
            f"{report.learned.seconds:.0f}",
            " ".join(["top"] * (report.number == best) + ["crash"] * report.crashed + ["kept"] * _refused(report)),
        )
        for report in reports
    ]
    title = "rounds: the model of each has learned from the logs of those before"
    return compact_table(title, headings, rows, left=("",))


def _percent(gain: Improvement) -> str:
    """An improvement in % with its interval; a dash where a log is too short to say."""
    if not math.isfinite(gain.low):
        return "–"
    return f"{100 * gain.value:.0f} ({100 * gain.low:.0f}…{100 * gain.high:.0f})"


def rounds_charts(reports: Sequence[RoundReport]) -> list[Chart]:
    """Position error of the episodes, where something flew, and of the predictions, by round."""
    rounds, charts = np.array([float(report.number) for report in reports]), []
    about = {
        "error": ("position error of the episodes", "mean distance from the reference"),
        "prediction": (f"prediction error {reports[0].horizon:.3g} s ahead", "on the round's own log, which is unseen"),
    }
    for name, (title, label) in about.items():
        values = np.array([getattr(report, name) for report in reports])
        if np.isfinite(values).any():
            first, last = (number(float(value), 2) for value in values[np.isfinite(values)][[0, -1]])
            unit = reports[0].unit
            reading = f"{first} {unit} in the first round, {last} {unit} in the last."
            labels = ("trajectories learned from", f"error in {unit}")
            lines = [Line(label, "model", values)]
            charts.append(Chart(title, reading, *labels, rounds, lines, zero=True, points=True))
    return charts


def rounds_figure(reports: Sequence[RoundReport]) -> Figure:
    """Position error of the episodes and of the predictions, by round; the model on top is marked."""
    figure = charts_figure(rounds_charts(reports))
    for axis in figure.axes:
        axis.axvline(best_of(reports), color="0.8", zorder=0, label="on top")
        axis.set_xticks([report.number for report in reports])
    return figure
