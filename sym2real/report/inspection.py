"""What a log seems to hold, as a table."""

from __future__ import annotations

from itertools import groupby

from rich.markup import escape
from rich.table import Table

from sym2real.logs import Inspection
from sym2real.report.tables import table_of

STYLE = {"certain": "green", "likely": "cyan", "guess": "yellow", "unknown": "red"}


def inspection_table(inspection: Inspection) -> Table:
    """A row for neighbouring columns that share unit and evidence, and rows on the whole."""
    headings = ("column", "what it seems to be", "unit", "evidence", "confidence")
    rows = []
    for (unit, evidence, confidence), same in groupby(
        inspection.rows, lambda row: (row.unit, row.evidence, row.confidence)
    ):
        columns, meanings = zip(*((row.column, row.meaning) for row in same), strict=True)
        texts = (", ".join(filter(None, columns)), ", ".join(dict.fromkeys(meanings)), unit, evidence)
        rows.append((*map(escape, texts), f"[{STYLE[confidence]}]{confidence}[/]"))
    title = ", ".join(path.name for path in inspection.paths)
    return table_of(title, headings, rows, left=headings, show_lines=True)
