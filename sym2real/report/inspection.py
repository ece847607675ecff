"""What a log seems to hold, as a table."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from sym2real.logs import Inspection
from sym2real.report.tables import table_of

STYLE = {"certain": "green", "likely": "cyan", "guess": "yellow", "unknown": "red"}


def inspection_table(inspection: Inspection) -> Table:
    """One row per column with the evidence, and rows on the whole."""
    headings = ("column", "what it seems to be", "unit", "evidence", "confidence")
    title = ", ".join(path.name for path in inspection.paths)
    table = table_of(title, *headings, left=headings, show_lines=True)
    for row in inspection.rows:
        confidence = f"[{STYLE[row.confidence]}]{row.confidence}[/]"
        table.add_row(*(escape(text) for text in (row.column, row.meaning, row.unit, row.evidence)), confidence)
    return table
