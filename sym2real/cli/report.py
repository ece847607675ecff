"""``sym2real report``: the page of what a folder holds, and the pages and recordings that other verbs write."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import tyro
from rich.console import Console

FILE = "report.html"


@dataclass(frozen=True)
class WriteReport:
    """Write the report of a folder that `diagnose`, `adapt` or `experiment` left: one HTML file that works offline.

    In it: how good the model is, where it fails, what is missing, what happens when it is added, what remains. Effects
    are switched on and off in the page. `diagnose`, `compare`, `run`, `adapt` and `experiment` write the same with
    --report FILE.

    Example: sym2real report runs/diagnosis
    """

    OUT_IS_FILE: ClassVar = True

    folder: tyro.conf.Positional[Path]
    """Folder of a diagnosis, an adaptation or an experiment."""
    out: Path | None = None
    """File; report.html in the folder by default."""
    json: Path | None = None
    """Write where the report is to this file (- is standard output)."""

    def run(self, console: Console) -> dict[str, Any]:
        """Read the folder, write the page."""
        from sym2real.cli.report_folder import page_of, write_report

        return {"report": write_report(page_of(self.folder, console), self.out or self.folder / FILE, console)}
