"""Progress of a sweep: a line for every answer with the time that is left, and below it what is going on."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from sym2real.experiments.study.sweep import Progress, running


@contextmanager
def sweep_progress(console: Console, folder: Path) -> Iterator[Callable[[Progress], None]]:
    """A callback for :func:`~sym2real.experiments.study.sweep.run_sweep` that draws on ``console``."""
    began, kept = time.monotonic(), list[int]()
    newest = [Progress(0, 0)]

    def going_on() -> Group:
        lines = [f"{newest[0].done} of {newest[0].total} answered", *(f"  {line}" for line in running(folder))]
        return Group(*(Text(line, style="dim", no_wrap=True, overflow="ellipsis") for line in lines))

    def show(progress: Progress) -> None:
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
