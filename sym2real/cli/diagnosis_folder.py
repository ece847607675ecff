"""The folder of a diagnosis: what it holds, and what goes when another diagnosis takes its place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console

from sym2real.cli.found import write_figures, write_simulator
from sym2real.cli.output import write_json
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis
from sym2real.errors import DataError
from sym2real.files import read_by, read_object
from sym2real.symbolic import Equations
from sym2real.symbolic.storage import PARTS, save_model

ANSWER, FILES = "diagnosis.json", "files"


def write_diagnosis(
    base: Equations, data: Dataset, diagnosis: Diagnosis, out: Path, console: Console
) -> dict[str, Any]:
    """Write the answer, its figures and, where something is established, model and simulator; Ctrl-C ends that.

    Args:
        base, data, diagnosis: the model, the logs and what they tell of it.
        out: the folder.
        console: is told where things are.

    Returns:
        What ``diagnosis.json`` holds: the diagnosis and, relative to the folder, the other files.
    """
    remove_earlier(out)
    written: list[str] = []
    result = {**diagnosis.to_dict(), FILES: written}
    write_json(result, out / ANSWER)  # what took minutes, before what takes seconds
    try:
        for file in _files(base, data, diagnosis, out, console):
            written.append(file.relative_to(out).as_posix())
        console.print(f"{ANSWER} and figures in {out}", markup=False)
    except KeyboardInterrupt:
        console.print(f"interrupted: {ANSWER} is in {out}, not all of the other files", markup=False)
    finally:
        write_json(result, out / ANSWER)
    return result


def _files(base: Equations, data: Dataset, diagnosis: Diagnosis, out: Path, console: Console) -> Iterator[Path]:
    informed = diagnosis.apply(base) if diagnosis.findings else None
    if informed is not None and diagnosis.established:
        model = save_model(informed, out / "model")
        yield from (model / name for name in PARTS)
        console.print(f"model with it in {model}", markup=False)
        yield from write_simulator(informed, out / "simulator", console)
    elif informed is not None:
        few = any(finding.provisional for finding in diagnosis.findings)
        why = "too little data to test it" if few else "held-out predictions do not bear it out"
        console.print(f"{why}: no model or simulator was written; `sym2real add` makes one", markup=False)
    yield from write_figures(base, informed, data, diagnosis, out)


def remove_earlier(out: Path) -> None:
    """Remove the files that the diagnosis in a folder says it wrote, and folders then empty; nothing that is read."""
    try:
        names = read_object(out / ANSWER, "an earlier diagnosis").get(FILES, [])
    except DataError:
        return
    for name in names if isinstance(names, list) else []:
        file = out / str(name)
        if file.resolve().is_relative_to(out.resolve()) and file.is_file() and not read_by(file):
            file.unlink()
            if file.parent != out and not any(file.parent.iterdir()):
                file.parent.rmdir()
