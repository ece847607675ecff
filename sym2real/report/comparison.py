"""A comparison of a model with logs, for the terminal."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.diagnosis import where_lines
from sym2real.report.sparkline import sparkline
from sym2real.report.tables import compact_table, decimals, number


def comparison_report(comparison: Comparison) -> RenderableType:
    """Everything a person reads of a comparison."""
    parts: list[RenderableType] = []
    if comparison.data is not None:
        parts += [f"[dim]data: {escape(line)}[/]" for line in comparison.data.lines()]
    parts += [comparison_table(comparison), floor_table(comparison), *where_lines(comparison.where)]
    parts += [f"[bold]worst[/] {escape(segment.statement)}" for segment in comparison.worst]
    if comparison.residuals is not None:
        parts += [escape(line) for line in comparison.residuals.lines()]
    parts += [f"[dim]note: {escape(note)}[/]" for note in comparison.notes]
    return Group(*parts)


def comparison_table(comparison: Comparison) -> Table:
    """Errors per channel over the horizon, in the channel's unit, beside "hold"."""
    table = compact_table("error at the end of windows, and that of holding the start")
    table.add_column("ahead\ns", justify="right", no_wrap=True)
    table.add_column("windows", justify="right", no_wrap=True)
    for channel, error in comparison.one_step.errors.items():
        table.add_column(f"{channel}\n{error.unit}", justify="right", no_wrap=True)
    for errors in (comparison.one_step, *comparison.horizons, comparison.free_run):
        cells = [f"{number(entry.value, 2)} [dim]{number(entry.hold, 2)}[/]" for entry in errors.errors.values()]
        table.add_row(number(errors.horizon), str(errors.windows), *cells)
    return table


def floor_table(comparison: Comparison) -> Table:
    """Errors near 0.8 s ahead beside what no model can do better, one row per channel.

    Also fit and skill, and how the error grows with the horizon.
    """
    shown = comparison.horizons or (comparison.one_step,)
    errors = min(shown, key=lambda at: abs(at.horizon - JUDGED_AT))
    table = compact_table(f"{errors.horizon:.3g} s ahead, beside what the sensors' noise alone makes")
    table.add_column("channel")
    for heading in ("error", "sensor\nnoise", "excess", "fit %", "skill\nhold", "skill\nmean"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column(f"to {max(at.horizon for at in shown):g} s", no_wrap=True)
    for channel, error in errors.errors.items():
        over = sparkline([at.errors[channel].value for at in (comparison.one_step, *comparison.horizons)])
        sizes = [number(value) for value in (error.value, error.floor, error.excess)]
        skills = (decimals(error.fit, 0), decimals(error.skill, 2), decimals(error.skill_mean, 2))
        table.add_row(f"{channel} {error.unit}", *sizes, *skills, over)
    return table
