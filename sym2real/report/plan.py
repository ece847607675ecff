"""What a manoeuvre would show, for the terminal."""

from rich.console import Group, RenderableType
from rich.markup import escape

from sym2real.diagnosis import Plan
from sym2real.report.diagnosis import note_lines
from sym2real.report.tables import compact_table, number

SOLE = "value"  # name of the one parameter that most effects have, which goes without saying
LONGEST = 7  # letters of a number with two digits
SIZES = (
    "found from: beyond chance in these manoeuvres; apart from: no longer taken for the nearest effect, which does "
    "most of the same; matters from: a tenth of the error of predictions goes with it. Where it matters before it is "
    "found, or apart, record more."
)


def plan_report(plan: Plan) -> RenderableType:
    """The smallest effect of each kind that would be found, and what these manoeuvres leave open."""
    rows = []
    for row in plan.visible:
        smallest = "[red]unseen[/]" if row.smallest is None else number(row.smallest, 2)
        separable, matters = ("–" if size is None else number(size, 2) for size in (row.separable, row.matters))
        name = row.effect if row.parameter == SOLE else f"{row.effect} {row.parameter}"
        nearest = "" if row.smallest is None else escape(row.nearest)
        rows.append((escape(name), smallest, separable, matters, row.unit, nearest))
    title = f"the smallest effect that {plan.seconds:.0f} s of these manoeuvres would show"
    head = ("effect", "found from", "apart from", "matters from", "unit", "nearest")
    table = compact_table(title, head, rows, left=("effect", "unit", "nearest"))
    for column in table.columns:
        column.no_wrap, column.min_width = column.justify == "left", LONGEST if column.justify == "right" else None
    table.columns[-1].overflow = "ellipsis"
    parts: list[RenderableType] = [table, SIZES]
    alike = {row.effect: [*row.like, *(f"{key} (never)" for key in row.always)] for row in plan.visible}
    if any(alike.values()):
        parts.append("[bold]what cannot be told apart here[/]")
        parts += [f"  {escape(effect)}: {escape(', '.join(others))}" for effect, others in alike.items() if others]
    if plan.blocks < 10:
        parts.append(f"only {plan.blocks} independent pieces: findings would be provisional; fly longer")
    parts += note_lines(plan.notes)
    advice = {row.effect: row.shown_by for row in plan.visible if row.separable is None or row.like}
    if advice:
        parts.append("[bold]what would show more[/]")
        parts += [f"  {escape(effect)}: {escape(shown_by)}" for effect, shown_by in advice.items()]
    return Group(*parts)
