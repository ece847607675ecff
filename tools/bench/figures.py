"""Figures of a benchmark: printed as a table with their bars, and written as JSON."""

import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from rich.console import Console
from rich.table import Table

from sym2real.files import write_text


@dataclass(frozen=True)
class Figure:
    """One measured number and the bar it is held against.

    Args:
        name: what was measured.
        value: in ``unit``.
        unit: SI, or what the name says.
        bar: what the issue asks, as "< 0.3", ">= 19" or "0.64 to 0.69"; empty where nothing is asked.
    """

    name: str
    value: float
    unit: str
    bar: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the bar is met; None where there is none."""
        if not self.bar:
            return None
        value = float(self.value)
        if " to " in self.bar:
            low, high = map(float, self.bar.split(" to "))
            return low <= value <= high
        sign, limit = self.bar.split()
        return {"<": value < float(limit), "<=": value <= float(limit), ">=": value >= float(limit)}[sign]


def say(text: str) -> None:
    """A line of what is going on, or why nothing is, beside the figures."""
    print(text, file=sys.stderr, flush=True)


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "torch": torch.__version__,
        "threads": torch.get_num_threads(),
    }


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor()


def report(title: str, figures: Sequence[Figure], seeds: Sequence[int], json_file: Path | None) -> None:
    """Print the table; write it as JSON where a file is given ("-" is standard output, and then the table is not)."""
    console = Console(stderr=json_file == Path("-"))
    table = Table(title=title, title_justify="left")
    for heading in ("figure", "value", "unit", "bar", ""):
        table.add_column(heading, justify="right" if heading in ("value", "bar") else "left", overflow="fold")
    for figure in figures:
        verdict = {None: "", True: "[green]holds[/]", False: "[red]missed[/]"}[figure.holds]
        table.add_row(figure.name, f"{figure.value:.4g}", figure.unit, figure.bar, verdict)
    console.print(table)
    if json_file is None:
        return
    rows = [asdict(figure) | {"value": float(figure.value), "holds": figure.holds} for figure in figures]
    text = json.dumps({"figures": rows, "machine": machine(), "seeds": list(seeds)}, indent=1)
    if json_file == Path("-"):
        print(text)
    else:
        write_text(json_file, text + "\n")
