"""What benches of many cases share: seeds, questions, answers that are kept, tables of them, shares with intervals."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
import tyro
from answers import Record
from figures import Figure, say
from rich.console import Console
from rich.table import Table
from scipy import stats

from sym2real.experiments.study.sweep import Job, Progress, Tell, run_sweep

Item = TypeVar("Item")
# Of cases that anybody may look at; those of the final run are in sealed_seeds.py.
DEVELOPMENT = 6_000_000


@dataclass(frozen=True)
class Asked:
    """A :class:`~sym2real.experiments.study.sweep.Job`: one question of a bench.

    Args:
        title: unlike any other's.
        asked: what the answer depends on.
        answer: gives it; takes what takes a line about what is going on.
    """

    title: str
    asked: Record
    answer: Callable[[Tell], Record]

    @property
    def name(self) -> str:
        """Of its file."""
        return re.sub(r"[^\w.#=-]+", "_", self.title)

    def run(self, tell: Tell) -> Record:
        """The answer."""
        return self.answer(tell)


@dataclass(frozen=True)
class Settings:
    """How much is run, and where answers stay.

    Args:
        cases: cases, of each robot where there are two; one seed each.
        seeds: these seeds instead, one case each.
        sealed: take the seeds of the final run, which nothing was tuned on.
        jobs: cases that run at the same time, each on one thread.
        folder: every answer is kept here, by bench; a run that was stopped goes on. Another version needs another
            folder.
        json: write the figures to this file (- is standard output).
    """

    cases: int = 4
    seeds: tuple[int, ...] = ()
    sealed: bool = False
    jobs: int = 1
    folder: Path = Path("build/bench")
    json: Path | None = None

    def seeds_of(self, bench: str) -> list[int]:
        """A seed per case."""
        if self.seeds:
            return list(self.seeds)
        first = DEVELOPMENT
        if self.sealed:
            from sealed_seeds import SEALED

            first = SEALED[bench]
        return list(range(first, first + self.cases))

    def place(self, bench: str) -> Path:
        """Folder of a bench's answers."""
        return self.folder / bench.replace(" ", "_")

    def answers(self, bench: str, jobs: Sequence[Job]) -> list[Record]:
        """Those of all jobs, in their order; progress on standard error.

        Raises:
            ModelError: when jobs failed, once all others are answered.
        """
        return answers_of(jobs, self.place(bench), self.jobs)


# Among the options of a bench that has others beside them.
Run = Annotated[Settings, tyro.conf.arg(name="")]


@dataclass(frozen=True)
class OfRobots:
    """A bench of several robots.

    Args:
        robots: robots to run.
    """

    run: Run = field(default_factory=Settings)
    robots: tuple[str, ...] = ("crazyflie", "mushr")


def answers_of(jobs: Sequence[Job], folder: Path, workers: int) -> list[Record]:
    """Answers of jobs, kept in a folder; order, progress and errors as of :meth:`Settings.answers`."""
    found = run_sweep(jobs, folder, workers=workers, on_progress=_say)
    return [found[job.name] for job in jobs]


def _say(progress: Progress) -> None:
    newest = f" {progress.newest} ({progress.seconds:.0f} s)" if progress.newest else ""
    say(f"{progress.done}/{progress.total}{newest}")


def spread_over(items: Sequence[Item], count: int) -> list[Item]:
    """So many of them, evenly over all; all where there are no more."""
    places = np.linspace(0, len(items) - 1, min(count, len(items))).round().astype(int)
    return [items[place] for place in np.unique(places)]


def print_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """What was said, on standard error."""
    table = Table(*headings, title=title, title_justify="left")
    for row in rows:
        table.add_row(*row)
    Console(stderr=True).print(table)


def share(name: str, flags: Iterable[bool], bar: str = "") -> list[Figure]:
    """The part that is true, with its 95 % interval (Wilson) in its name; no figure of nothing."""
    counted = list(flags)
    if not counted:
        return []
    true = sum(counted)
    interval = stats.binomtest(true, len(counted)).proportion_ci(0.95, method="wilson")
    said = f"{name}: {true} of {len(counted)} (95 %: {interval.low:.2f} to {interval.high:.2f})"
    return [Figure(said, true / len(counted), "", bar)]


def spread(name: str, values: Sequence[float], unit: str = "", bar: str = "") -> list[Figure]:
    """The median, which has a bar, and the 90th percentile; no figures of nothing."""
    if not values:
        return []
    return [
        Figure(f"{name}: median of {len(values)}", float(np.median(values)), unit, bar),
        Figure(f"{name}: p90", float(np.quantile(values, 0.9)), unit),
    ]
