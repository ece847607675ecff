"""The catalogue of effects, and the page of one."""

from collections.abc import Sequence
from dataclasses import replace

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table

from sym2real.effects import Effect, Kind
from sym2real.effects.kind import Parameter
from sym2real.layout import Layout
from sym2real.report.tables import table_of
from sym2real.vocabulary import UNLIMITED


def catalogue_table(kinds: Sequence[Kind], title: str) -> Table:
    """One row per kind of effect."""
    headings = ("effect", "acts on", "what it is")
    rows = ((f"{kind.name}:" if kind.columns else kind.name, kind.stage, escape(kind.summary)) for kind in kinds)
    return table_of(f"physical effects: {title}", headings, rows, left=headings)


def effect_page(effect: Effect) -> RenderableType:
    """Everything that the catalogue says of one effect."""
    kind, layouts = effect.of, effect.body.layouts
    tables = [_parameters("parameters", effect.parameters)]
    if more := [name for name in kind.reads if name not in layouts.inputs]:
        inputs = layouts.inputs + Layout.of(tuple(more))
        body = replace(effect.body, layouts=replace(layouts, inputs=inputs))
        tables.append(_parameters(f"parameters where logs hold {', '.join(more)}", kind.parameters(body)))
    lines = (
        f"[bold]{effect.key}[/]: {escape(kind.summary)}",
        f"formula: {escape(kind.formula)}",
        f"confused with: {escape(kind.confused_with)}",
        f"shown by: {escape(kind.shown_by)}",
        f"fix: {escape(kind.fix)}",
        *([f"cannot be told from: {', '.join(effect.group)}"] if effect.group else []),
    )
    return Group(*lines, *tables)


def _parameters(title: str, parameters: Sequence[Parameter]) -> Table:
    headings = ("name", "unit", "null", "lowest", "highest", "expected size")
    rows = ((slot.name, slot.unit, *map(_number, (slot.null, slot.low, slot.high, slot.scale))) for slot in parameters)
    return table_of(title, headings, rows, left=headings[:2])


def _number(value: float) -> str:
    return "none" if abs(value) >= UNLIMITED else f"{value:.3g}"
