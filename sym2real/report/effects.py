"""The catalogue of effects, and the page of one."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.effects import Effect, Kind
from sym2real.effects.kind import UNLIMITED
from sym2real.report.tables import table_of


def catalogue_table(kinds: Sequence[Kind], title: str) -> Table:
    """One row per kind of effect."""
    headings = ("effect", "acts on", "what it is")
    table = table_of(f"physical effects: {title}", *headings, left=headings)
    for kind in kinds:
        table.add_row(f"{kind.name}:" if kind.columns else kind.name, kind.stage, escape(kind.summary))
    return table


def effect_page(effect: Effect) -> RenderableType:
    """Everything that the catalogue says of one effect."""
    kind = effect.of
    headings = ("name", "unit", "null", "lowest", "highest", "expected size")
    table = table_of("parameters", *headings, left=headings[:2])
    for parameter in effect.parameters:
        numbers = (parameter.null, parameter.low, parameter.high, parameter.scale)
        table.add_row(parameter.name, parameter.unit, *(_number(value) for value in numbers))
    lines = (
        f"[bold]{effect.key}[/]: {escape(kind.summary)}",
        f"formula: {escape(kind.formula)}",
        f"confused with: {escape(kind.confused_with)}",
        f"shown by: {escape(kind.shown_by)}",
        f"fix: {escape(kind.fix)}",
        *([f"cannot be told from: {', '.join(effect.group)}"] if effect.group else []),
    )
    return Group(*lines, table)


def _number(value: float) -> str:
    return "none" if abs(value) >= UNLIMITED else f"{value:.3g}"
