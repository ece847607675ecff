"""Progress on standard error: a bar on a terminal, now and then a line in a file or a pipe."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich import progress as bars
from rich.console import Group
from rich.live import Live
from rich.text import Text

from sym2real.cli.terminal import progress_console
from sym2real.report.tables import number

if TYPE_CHECKING:
    from sym2real import adaptation
    from sym2real.experiments.study import sweep

SECONDS_BETWEEN_LINES = 10.0  # where there is no terminal


@contextmanager
def stage_one_progress() -> Iterator[Callable[[adaptation.Progress], None]]:
    """A callback for :func:`sym2real.adaptation.learn_base`."""
    with _bar(bars.BarColumn(), bars.MofNCompleteColumn()) as bar:
        task = bar.add_task("starting", total=None)

        def show(progress: adaptation.Progress) -> None:
            if progress.report is not None:
                progress_console().print(finished_line(progress.report), markup=False)
            else:
                bar.update(task, description=progress.what, completed=progress.done, total=progress.total or None)

        yield show


@contextmanager
def stages_progress() -> Iterator[Callable[[str], None]]:
    """A callback for what is being done, with the time that has passed."""
    with _bar() as bar:
        task = bar.add_task("starting", total=None)
        yield (lambda what: bar.update(task, description=what)) if progress_console().is_terminal else _lines()


def finished_line(report: adaptation.EpisodeReport | adaptation.RoundReport) -> str:
    """One finished episode or round in words."""
    from sym2real.adaptation import EpisodeReport  # heavy, and loaded by whoever has a report

    unit = report.unit
    if isinstance(report, EpisodeReport):
        error = "" if report.tracking != report.tracking else f", mean position error {number(report.tracking)} {unit}"
        return f"episode {report.number + 1}: {report.task}, {report.rows} rows, {report.crashes} crashes{error}"
    refused = f"; what was learned is not used: {report.learned.refused}" if report.learned.refused else ""
    error = "" if report.error != report.error else f"mean position error {number(report.error)} {unit}, "
    ahead = f"prediction {report.horizon:g} s ahead {number(report.prediction)} {unit} off"
    crashed = "crashed, " if report.crashed else ""
    return f"round {report.number} on {report.log}: {crashed}{error}{ahead}{refused}"


def _lines() -> Callable[[str], None]:
    """Print a line where another kind of work begins, and every ten seconds while it goes on."""
    started = time.monotonic()
    printed, kind = -SECONDS_BETWEEN_LINES, ""

    def show(what: str) -> None:
        nonlocal printed, kind
        passed, first = time.monotonic() - started, what.partition(" ")[0]
        if first != kind or passed - printed >= SECONDS_BETWEEN_LINES:
            progress_console().print(f"{passed:.0f} s: {what}", markup=False, soft_wrap=True)
            printed, kind = passed, first

    return show


@contextmanager
def steps_progress(what: str, steps: int) -> Iterator[Callable[[int], None]]:
    """A callback that takes the number of steps done."""
    with _bar(bars.BarColumn(), bars.MofNCompleteColumn()) as bar:
        task = bar.add_task(what, total=steps)
        yield lambda done: bar.update(task, completed=done)


def _bar(*counted: bars.ProgressColumn) -> bars.Progress:
    columns = (bars.SpinnerColumn(), bars.TextColumn("{task.description}"), *counted, bars.TimeElapsedColumn())
    console = progress_console()
    return bars.Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


@contextmanager
def sweep_progress(folder: Path) -> Iterator[Callable[[sweep.Progress], None]]:
    """A callback for :func:`~sym2real.experiments.study.sweep.run_sweep` into this folder."""
    from sym2real.experiments.study import sweep  # heavy, and loaded by whoever sweeps

    console, began = progress_console(), time.monotonic()
    kept: list[int] = []
    newest = [sweep.Progress(0, 0)]

    def going_on() -> Group:
        lines = [f"{newest[0].done} of {newest[0].total} answered", *(f"  {line}" for line in sweep.running(folder))]
        return Group(*(Text(line, style="dim", no_wrap=True, overflow="ellipsis") for line in lines))

    def show(progress: sweep.Progress) -> None:
        """Take the newest state, and print what has just ended."""
        kept[:] = kept or [progress.done]
        newest[0] = progress
        if progress.newest:
            here = progress.done - kept[0]
            left = (time.monotonic() - began) / here * (progress.total - progress.done)
            remaining = f"; {duration(left)} left" if progress.done < progress.total else ""
            line = f"{progress.done}/{progress.total} {progress.newest} ({duration(progress.seconds)}{remaining})"
            console.print(line, markup=False)
        elif progress.done:
            console.print(f"{progress.done} of {progress.total} were answered before", markup=False)

    with Live(get_renderable=going_on, console=console, transient=True, refresh_per_second=2):
        yield show


def duration(seconds: float) -> str:
    """A time as people say it: 40 s, 12 min, 1.5 h."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 100 * 60 else f"{seconds / 3600:.1f} h"
