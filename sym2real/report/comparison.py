"""A comparison of a model with logs, for the terminal."""

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.diagnosis import note_lines, where_lines
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
    parts += note_lines(comparison.notes)
    return Group(*parts)


def comparison_table(comparison: Comparison) -> Table:
    """Errors per channel over the horizon, in the channel's unit, beside "hold"."""
    headings = ["ahead\ns", "windows", *(f"{name}\n{error.unit}" for name, error in comparison.one_step.errors.items())]
    rows = []
    for errors in (comparison.one_step, *comparison.horizons, comparison.free_run):
        cells = [f"{number(entry.value, 2)} [dim]{number(entry.hold, 2)}[/]" for entry in errors.errors.values()]
        rows.append((number(errors.horizon), str(errors.windows), *cells))
    return compact_table("error at the end of windows, and that of holding the start", headings, rows)


def floor_table(comparison: Comparison) -> Table:
    """Errors near 0.8 s ahead beside what no model can do better, one row per channel; fit and skill."""
    errors = comparison.at(JUDGED_AT)
    headings = ("channel", "error", "sensor\nnoise", "excess", "fit %", "skill\nhold", "skill\nmean")
    rows = []
    for channel, error in errors.errors.items():
        sizes = [number(value) for value in (error.value, error.floor, error.excess)]
        skills = (decimals(error.fit, 0), decimals(error.skill, 2), decimals(error.skill_mean, 2))
        rows.append((f"{channel} {error.unit}", *sizes, *skills))
    title = f"{errors.horizon:.3g} s ahead, beside what the sensors' noise alone makes"
    return compact_table(title, headings, rows, left=("channel",))
