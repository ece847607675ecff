"""The page that a verb writes with ``--report``."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from sym2real.report.html.page import Page
from sym2real.report.html.render import write_page


def title_of(place: object, done: str) -> str:
    """A page's heading: the last part of what a user named, and what was done with it."""
    return f"{Path(str(place)).name or place}, {done}"


def write_report(page: Page, file: Path, console: Console) -> Path:
    """Write a page, say where it is."""
    write_page(page, file)
    console.print(f"report in {file}", markup=False)
    return file
