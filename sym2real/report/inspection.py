"""What a log seems to hold, as a table."""

from itertools import groupby

from rich.markup import escape
from rich.table import Table

from sym2real.logs import Inspection
from sym2real.report.tables import table_of

MOST_NAMED = 6  # in a row of the table; a message has dozens of covariances
STYLE = {"certain": "green", "likely": "cyan", "guess": "yellow", "unknown": "red"}


def inspection_table(inspection: Inspection) -> Table:
    """A row for neighbouring columns that share unit and evidence, and rows on the whole."""
    headings = ("column", "what it seems to be", "unit", "evidence", "confidence")
    rows = []
    for (unit, evidence, confidence), same in groupby(
        inspection.rows, lambda row: (row.unit, row.evidence, row.confidence)
    ):
        columns, meanings = zip(*((row.column, row.meaning) for row in same), strict=True)
        named = columns if len(columns) <= MOST_NAMED else (columns[0], "…", f"{columns[-1]} ({len(columns)} columns)")
        texts = (", ".join(filter(None, named)), ", ".join(dict.fromkeys(meanings)), unit, evidence)
        rows.append((*map(escape, texts), f"[{STYLE[confidence]}]{confidence}[/]"))
    title = ", ".join(path.name for path in inspection.paths)
    return table_of(title, headings, rows, left=headings, show_lines=True)
