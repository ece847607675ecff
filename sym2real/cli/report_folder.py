"""The page of a folder that another verb left, by the file that says which."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console

from sym2real.adaptation.rounds import ANSWER as ADAPTED
from sym2real.adaptation.rounds import LOG, round_folder, rounds_in
from sym2real.cli.diagnosis_folder import ANSWER as DIAGNOSED
from sym2real.cli.diagnosis_folder import ASKED
from sym2real.cli.experiment import ANSWER as STUDIED
from sym2real.cli.model import equations_below, logs_for
from sym2real.cli.of_logs import OfLogs
from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.sanity import check
from sym2real.errors import DataError
from sym2real.files import read_object
from sym2real.logs import read_log
from sym2real.neural.composed import in_double
from sym2real.neural.model_folder import open_model
from sym2real.report.html.page import Page
from sym2real.report.html.pages import diagnosis_page
from sym2real.report.html.render import write_page
from sym2real.report.html.rounds import adaptation_page
from sym2real.report.html.study import study_page
from sym2real.report.reading import read_diagnosis, read_outcome


def page_of(folder: Path, console: Console) -> Page:
    """The page of a diagnosis, an adaptation or an experiment.

    Raises:
        DataError: for a folder that holds none of them, or not all that a page needs.
    """
    kinds: dict[str, Callable[[Path, Console], Page]] = {DIAGNOSED: _diagnosis, ADAPTED: _adaptation, STUDIED: _study}
    for name, page in kinds.items():
        if (folder / name).is_file():
            return page(folder, console)
    raise DataError(folder, f"a folder with {', '.join(kinds)}", "none of them")


def _diagnosis(folder: Path, console: Console) -> Page:
    asked: Any = read_object(folder / DIAGNOSED, "a diagnosis").get(ASKED)
    if not isinstance(asked, dict) or asked.keys() != {"model", "logs", "spec", "columns"}:
        raise DataError(
            folder / DIAGNOSED, f"model, logs, spec and columns of the diagnosis under '{ASKED}'", repr(asked)
        )
    base, notes = equations_below(str(asked["model"]), console)
    naming = OfLogs(spec=asked["spec"], columns=tuple(asked["columns"])).naming
    data = logs_for(base, [Path(log) for log in asked["logs"]], naming)
    diagnosis = read_diagnosis(folder / DIAGNOSED)
    return diagnosis_page(base, check(base, data).data, diagnosis, title_of(asked["model"], "diagnosed"), notes)


def _adaptation(folder: Path, console: Console) -> Page:
    del console
    reports, on_top = rounds_in(folder), read_object(folder / ADAPTED, "an adaptation").get("on_top")
    if not isinstance(on_top, int) or not 0 <= on_top < len(reports):
        raise DataError(folder / ADAPTED, f"a round that is there (0 to {len(reports) - 1}) as 'on_top'", repr(on_top))
    given, adapted = (in_double(open_model(round_folder(folder, number))) for number in (0, on_top))
    files = [round_folder(folder, report.number) / LOG for report in reports[on_top:]]
    if not all(file.is_file() for file in files):
        raise DataError(folder, "logs of its rounds", "recorded ones, which stay where they are: adapt with --report")
    unseen = Dataset(read_log(file) for file in files)
    return adaptation_page((given, adapted), unseen, reports, on_top, title_of(folder, "adapted"))


def _study(folder: Path, console: Console) -> Page:
    del console
    return study_page(read_outcome(folder / STUDIED))


def title_of(place: object, done: str) -> str:
    """A page's heading: the last part of what a user named, and what was done with it."""
    return f"{Path(str(place)).name or place}, {done}"


def write_report(page: Page, file: Path, console: Console) -> Path:
    """Write a page, say where it is."""
    write_page(page, file)
    console.print(f"report in {file}", markup=False)
    return file
