"""What benches of many cases share: seeds, answers that are kept, shares with intervals."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from figures import Figure
from scipy import stats

from sym2real.experiments.study.sweep import Job, Progress, run_sweep

Record = dict[str, Any]

# Of cases that anybody may look at; those of the final run are in sealed_seeds.py.
DEVELOPMENT = 6_000_000


@dataclass(frozen=True)
class Settings:
    """How much is run, and where answers stay."""

    cases: int = 4
    """Cases, of each robot where there are two; one seed each."""
    seeds: tuple[int, ...] = ()
    """These seeds instead, one case each."""
    sealed: bool = False
    """Take the seeds of the final run, which nothing was tuned on."""
    jobs: int = 1
    """Cases that run at the same time, each on one thread."""
    folder: Path = Path("build/bench")
    """Every answer is kept here, by bench; a run that was stopped goes on. Another version needs another folder."""
    json: Path | None = None
    """Write the figures to this file (- is standard output)."""

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
        found = run_sweep(jobs, self.place(bench), workers=self.jobs, on_progress=_say)
        return [found[job.name] for job in jobs]


def _say(progress: Progress) -> None:
    newest = f" {progress.newest} ({progress.seconds:.0f} s)" if progress.newest else ""
    print(f"{progress.done}/{progress.total}{newest}", file=sys.stderr, flush=True)


def share(name: str, flags: Iterable[bool], bar: str = "") -> list[Figure]:
    """The part that is true, with its 95 % interval (Wilson) in its name; no figure of nothing."""
    counted = list(flags)
    if not counted:
        return []
    true = sum(counted)
    interval = stats.binomtest(true, len(counted)).proportion_ci(0.95, method="wilson")
    said = f"{name}: {true} of {len(counted)} (95 %: {interval.low:.2f} to {interval.high:.2f})"
    return [Figure(said, true / len(counted), "", bar)]
