"""``sym2real report``: the page of what a folder holds, and the pages and recordings that other verbs write."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import tyro
from rich.console import Console

if TYPE_CHECKING:
    from sym2real.dataset import Dataset
    from sym2real.neural.composed import Base
    from sym2real.report.html.page import Page
    from sym2real.report.html.variants import Predicting

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
        from sym2real.cli.report_folder import page_of

        return {"report": write_report(page_of(self.folder, console), self.out or self.folder / FILE, console)}


def write_report(page: Page, file: Path, console: Console) -> Path:
    """Write a page, say where it is."""
    from sym2real.report.html.render import write_page

    write_page(page, file)
    console.print(f"report in {file}", markup=False)
    return file


def write_recording(file: Path, data: Dataset, models: Mapping[str, Predicting], of: Base, console: Console) -> Path:
    """Write what was measured and what models predict, with the robot of a model where it is known; say where it is."""
    from sym2real.plants import MujocoPlant
    from sym2real.plants.geometry import geometries
    from sym2real.report.rerun_file import write_rerun
    from sym2real.robots.own import robot_of

    robot = robot_of(of)
    write_rerun(file, data, models, () if robot is None else geometries(MujocoPlant(robot)))
    console.print(f"recording in {file}: rerun {file}", markup=False)
    return file
