"""Where a verb's result goes: its words to the terminal, its figures as JSON to a file or to standard output."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from sym2real.cli.terminal import encoding_of, put
from sym2real.files import write_text
from sym2real.json_objects import plain

if TYPE_CHECKING:
    from sym2real.protocols import Plant
    from sym2real.report.html.page import Page
    from sym2real.trajectory import Trajectory

STANDARD_OUTPUT = Path("-")


def write_json(result: dict[str, Any], json_file: Path | None) -> None:
    """Write a verb's result to a file, where ``--json`` names one; :func:`show_json` writes to standard output."""
    if json_file not in (None, STANDARD_OUTPUT):
        write_text(json_file, _text(result, "utf-8") + "\n")


def show_json(result: dict[str, Any]) -> None:
    """Write a verb's result to standard output."""
    put(sys.stdout, _text(result, encoding_of(sys.stdout)) + "\n")


def crash_of(plant: Plant, log: Trajectory) -> str:
    """When and by what an episode in a plant ended early, for a sentence."""
    return f"crashed after {len(log) * plant.dt:g} s ({getattr(plant, 'ended_by', '') or 'no reason is known'})"


def title_of(place: object, done: str) -> str:
    """A page's heading: the last part of what a user named, and what was done with it."""
    return f"{Path(str(place)).name or place}, {done}"


def write_report(page: Page, file: Path, console: Console) -> Path:
    """Write the page of ``--report``, say where it is."""
    from sym2real.report.html.render import write_page

    write_page(page, file)
    console.print(f"report in {file}", markup=False)
    return file


def _text(result: dict[str, Any], encoding: str) -> str:
    """JSON; numbers that it lacks (NaN, infinity) become null, letters that an encoding lacks are escaped."""
    written = plain(result)
    text = json.dumps(written, indent=1, ensure_ascii=False)
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return json.dumps(written, indent=1)
    return text
