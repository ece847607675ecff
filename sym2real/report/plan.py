"""What a manoeuvre would show, for the terminal."""

from rich.console import Group, RenderableType
from rich.markup import escape

from sym2real.diagnosis import Plan
from sym2real.diagnosis.settings import SETTINGS
from sym2real.report.diagnosis import note_lines
from sym2real.report.tables import compact_table, number

SOLE = "value"  # name of the one parameter that most effects have, which goes without saying
LONGEST = 7  # letters of a number with two digits
SIZES = (
    "found from: beyond chance in these manoeuvres; matters from: a tenth of the error of predictions goes with it. "
    "Where it matters before it is found, record more."
)


def plan_report(plan: Plan) -> RenderableType:
    """The smallest effect of each kind that would be found, and what these manoeuvres leave open."""
    rows, apart = [], list[str]()
    for row in plan.visible:
        smallest = "[red]unseen[/]" if row.smallest is None else number(row.smallest, 2)
        matters = "–" if row.matters is None else number(row.matters, 2)
        name = row.effect if row.parameter == SOLE else f"{row.effect} {row.parameter}"
        rows.append((escape(name), smallest, matters, row.unit))
        if row.smallest is not None and (row.separable is None or row.separable > SETTINGS.gap * row.smallest):
            unit = "" if row.unit == "1" else f" {row.unit}"
            size = "at no size" if row.separable is None else f"from {number(row.separable, 2)}{unit} on"
            apart.append(f"  {escape(name)}: {escape(row.nearest)}, {size}")
    title = f"the smallest effect that {plan.seconds:.0f} s of these manoeuvres would show"
    table = compact_table(title, ("effect", "found from", "matters from", "unit"), rows, left=("effect", "unit"))
    for column in table.columns:
        column.no_wrap, column.min_width = column.justify == "left", LONGEST if column.justify == "right" else None
    parts: list[RenderableType] = [table, SIZES]
    alike = {row.effect: [*row.like, *(f"{key} (never)" for key in row.always)] for row in plan.visible}
    if any(alike.values()):
        parts.append("[bold]what cannot be told apart here[/]")
        parts += [f"  {escape(effect)}: {escape(', '.join(others))}" for effect, others in alike.items() if others]
    if apart:
        parts += ["[bold]what is found before it is told from the effect that does most of the same[/]", *apart]
    if plan.blocks < 10:
        parts.append(f"only {plan.blocks} independent pieces: findings would be provisional; fly longer")
    parts += note_lines(plan.notes)
    advice = {row.effect: row.shown_by for row in plan.visible if row.separable is None or row.like}
    if advice:
        parts.append("[bold]what would show more[/]")
        parts += [f"  {escape(effect)}: {escape(shown_by)}" for effect, shown_by in advice.items()]
    return Group(*parts)
