"""What a log seems to hold, as a table."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from sym2real.logs import Inspection

STYLE = {"certain": "green", "likely": "cyan", "guess": "yellow", "unknown": "red"}


def inspection_table(inspection: Inspection) -> Table:
    """One row per column with the evidence, and rows on the whole."""
    table = Table(title=", ".join(path.name for path in inspection.paths), title_justify="left", show_lines=True)
    for heading in ("column", "what it seems to be", "unit", "evidence", "confidence"):
        table.add_column(heading, overflow="fold")
    for row in inspection.rows:
        confidence = f"[{STYLE[row.confidence]}]{row.confidence}[/]"
        table.add_row(*(escape(text) for text in (row.column, row.meaning, row.unit, row.evidence)), confidence)
    return table
