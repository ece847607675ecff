"""What an adaptation has led to: a table for the terminal, and the errors of every round as a figure."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from rich.console import Group
from rich.table import Table
from rich.text import Text

from sym2real.adaptation import Improvement, RoundReport
from sym2real.report.style import INFORMED, PREDICTED, legend_below, logarithmic
from sym2real.report.tables import compact_table, number


def rounds_table(reports: Sequence[RoundReport], on_top: int, settled: bool) -> Group:
    """One row per round, and what the figures mean.

    Args:
        reports: of every round.
        on_top: round whose model is the one that the folder's verbs open.
        settled: whether the run ended because nothing got better.
    """
    ahead = f"{reports[0].horizon:g} s"
    headings = ("round", "rows", "error m", "% better", "cost", f"{ahead} m", "% better", "λ", "s", "")
    table = compact_table("rounds: the model of each has learned from the logs of those before", *headings, left=("",))
    for report in reports:
        _add_row(table, report, report.number == on_top)
    best = reports[on_top]
    lines = [
        f"error: mean distance from the reference; {ahead}: error of the position predicted that far ahead, on the "
        "round's own log, which its model has not seen",
        "% better: than the best model before, with its 95 % interval, row by row and on the same log",
        "rows: learned from; cost: mean running cost of the task; λ: weight of the residual's size; s: of the training",
        "kept: what was learned is not used; crash: the episode ended early",
        f"on top, where verbs open it: the model of round {best.number}",
    ]
    lines += [
        f"round {entry.number}: kept the model before: {entry.learned.refused}" for entry in reports if _refused(entry)
    ]
    effects = best.learned.effects
    lines += [f"effects in the equations: {', '.join(effects)}"] if effects else []
    what = "position error" if reports[0].flown else "prediction"
    lines += [f"ended: two rounds in a row have not improved the {what} beyond its interval"] if settled else []
    return Group(table, *(Text(line) for line in lines))


def _refused(report: RoundReport) -> bool:
    return bool(report.learned.refused)


def _add_row(table: Table, report: RoundReport, on_top: bool) -> None:
    remarks = ["top"] * on_top + ["crash"] * report.crashed + ["kept"] * _refused(report)
    table.add_row(
        str(report.number),
        str(report.learned.rows),
        number(report.error),
        percent(report.tracking),
        number(report.cost),
        number(report.prediction, 2),
        percent(report.gain),
        number(report.learned.penalty, 1),
        f"{report.learned.seconds:.0f}",
        " ".join(remarks),
    )


def percent(gain: Improvement) -> str:
    """An improvement in % with its interval; a dash where a log is too short to say."""
    if not math.isfinite(gain.low):
        return "–"
    return f"{100 * gain.value:.0f} ({100 * gain.low:.0f}…{100 * gain.high:.0f})"


def rounds_figure(reports: Sequence[RoundReport], on_top: int) -> Figure:
    """Position error of the episodes and of the predictions, by round; the model on top is marked."""
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axis = figure.subplots()
    rounds = [report.number for report in reports]
    flown, predicted = ([getattr(report, name) for report in reports] for name in ("error", "prediction"))
    if not all(math.isnan(error) for error in flown):
        axis.plot(rounds, flown, "o-", color=INFORMED, label="mean distance from the reference")
    axis.plot(rounds, predicted, "s--", color=PREDICTED, label=f"prediction {reports[0].horizon:g} s ahead")
    axis.axvline(on_top, color="0.8", zorder=0, label="on top")
    axis.set(xlabel="trajectories learned from", ylabel="position error in m", xticks=rounds)
    logarithmic(axis)
    legend_below(figure)
    return figure
