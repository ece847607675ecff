"""What a manoeuvre would show, for the terminal."""

from __future__ import annotations

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.diagnosis import Plan
from sym2real.report.tables import number


def plan_report(plan: Plan) -> RenderableType:
    """The smallest effect of each kind that would be found, and what these manoeuvres leave open."""
    table = Table(
        title=f"the smallest effect that {plan.seconds:.0f} s of these manoeuvres would show",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    table.add_column("effect", no_wrap=True)
    table.add_column("parameter", no_wrap=True)
    table.add_column("found from", justify="right", no_wrap=True)
    table.add_column("matters from", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("cannot be told from", overflow="fold")
    before = ""
    for row in plan.visible:
        smallest = "[red]unseen[/]" if row.smallest is None else number(row.smallest, 2)
        matters = "–" if row.matters is None else number(row.matters, 2)
        like = ", ".join([*row.like, *(f"{key} (never)" for key in row.always)])
        name = "" if row.effect == before else row.effect
        table.add_row(escape(name), row.parameter, smallest, matters, row.unit, escape(like) if name else "")
        before = row.effect
    parts: list[RenderableType] = [table, "matters from: a tenth of the error of predictions goes with the effect"]
    if plan.blocks < 10:
        parts.append(f"only {plan.blocks} independent pieces of a second: findings would be provisional; fly longer")
    parts += [f"[dim]note: {escape(note)}[/]" for note in plan.notes]
    advice = {row.effect: row.shown_by for row in plan.visible if row.smallest is None or row.like}
    if advice:
        parts.append("[bold]what would show more[/]")
        parts += [f"  {escape(effect)}: {escape(shown_by)}" for effect, shown_by in advice.items()]
    return Group(*parts)
