"""Bars of the adaptation study: what adapts, how fast, how far, against MPPI that plans with MuJoCo itself.

Runs what is missing in the folder and keeps it there, so that a part of the study can be run now and the rest later:

    python tools/bench/adaptation.py --out build/adaptation --cases mass-26 friction --seeds 1
    python tools/bench/adaptation.py --out build/adaptation --json build/adaptation.json

What MuJoCo itself reaches is kept in ``adaptation_references.json``, and taken from there while it still holds.
Without ``--cases`` the bases from scratch belong to it. ``--quick`` takes one seed, and a case of each kind.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import tyro
from adaptation_bars import Bars
from adaptation_logs import log_figures
from adaptation_page import page
from adaptation_references import keep, take_known
from figures import Figure, report, say

from sym2real.experiments.study.case import load_suite
from sym2real.experiments.study.effort import FULL, QUICK, Effort
from sym2real.experiments.study.judged import REFERENCE, Reference
from sym2real.experiments.study.scratch import scratch_jobs
from sym2real.experiments.study.suites import suite_jobs
from sym2real.experiments.study.sweep import Job, Progress, kept, run_sweep
from sym2real.files import write_text

SUITES = ("sim2sim", "uncovered", "delay")
KINDS = ("mass-26", "friction", "swinging-payload", "car-200-ms")
NEEDED = (REFERENCE, "sr-nn", "sr-effect", "sr-effect-nn", "sr-memory")


@dataclass(frozen=True)
class Options:
    """Measure the bars of the adaptation study.

    Args:
        out: folder that keeps the answers.
        quick: one seed, and a case of each kind.
        full: the paper's own size.
        cases: only these cases.
        contestants: only these contestants; what the bars ask for by default, of whom mujoco takes longest.
        seeds: only these seeds; 1 2 3 by default.
        jobs: processes on this machine.
        cluster: address of a dask scheduler instead.
        logs: also the measured logs of the authors' car, where they lie beside the project.
        only_kept: run nothing: figures of the answers that are there.
        json: write the figures to this file (- is standard output).
        page: write errors and figures as a page of the docs.
    """

    out: Path = Path("build/adaptation")
    quick: bool = False
    full: bool = False
    cases: tuple[str, ...] = ()
    contestants: tuple[str, ...] = NEEDED
    seeds: tuple[int, ...] = ()
    jobs: int = 2
    cluster: str = ""
    logs: bool = True
    only_kept: bool = False
    json: Path | None = None
    page: Path | None = None


def effort_of(options: Options) -> Effort:
    """Quick or full, with the chosen seeds."""
    effort = FULL if options.full else QUICK
    seeds = options.seeds or ((effort.seeds[0],) if options.quick else effort.seeds)
    return replace(effort, seeds=seeds)


def jobs_of(options: Options, effort: Effort) -> list[Job]:
    """Of every suite the chosen cases and those contestants that were chosen, MuJoCo too; then bases from scratch."""
    wanted = options.cases or (KINDS if options.quick else ())
    jobs: list[Job] = []
    for name in SUITES:
        suite = load_suite(name)
        cases = tuple(case for case in suite.cases if not wanted or case.name in wanted)
        asked = tuple(one for one in suite.contestants if one in options.contestants)
        jobs += suite_jobs(replace(suite, cases=cases, contestants=asked), effort) if cases else []
    jobs = [job for job in jobs if REFERENCE in options.contestants or not isinstance(job, Reference)]
    return jobs if wanted else jobs + scratch_jobs(effort)


def say_answered(progress: Progress) -> None:
    """A line for every answer."""
    if progress.newest:
        say(f"{progress.done}/{progress.total} {progress.newest} ({progress.seconds:.0f} s)")


def figures_of(bars: Bars) -> list[Figure]:
    """Every bar that the answers say something about."""
    sim2sim, uncovered, delay = (load_suite(name) for name in SUITES)
    shifts = [case for case in sim2sim.cases if case.effects]
    others = [*(case for case in sim2sim.cases if not case.effects), *uncovered.cases]
    return [
        *bars.against_mujoco(sim2sim),
        *bars.effect_at_once(shifts),
        *bars.no_harm(others),
        *bars.safety([*shifts, *others]),
        *bars.scratch(),
        *bars.delay(delay),
        *bars.training(),
        *whole_study(bars),
    ]


def whole_study(bars: Bars) -> list[Figure]:
    """What all of the study's jobs would take on two cores, by what those of a contestant have taken."""
    seconds: dict[str, list[float]] = {}
    for name, record in bars.answers.items():
        seconds.setdefault(kind_of(name), []).append(record["seconds"])
    usual = {kind: sum(found) / len(found) for kind, found in seconds.items()}
    every = [job.name for job in jobs_of(Options(), replace(bars.effort, seeds=QUICK.seeds))]
    guess = sum(usual.values()) / len(usual)
    total = sum(usual.get(kind_of(name), guess) for name in every)
    return [Figure(f"all {len(every)} jobs on two cores, by those that ran", total / 2 / 3600, "h", "<= 2")]


def kind_of(name: str) -> str:
    """The contestant, or the robot from scratch; MuJoCo's rollouts of a car are slower than those of a quadrotor."""
    case, kind = name.split("_")[:2]
    return name if kind == REFERENCE else f"{case} {kind}" if case.startswith("scratch") else kind


def main(options: Options) -> None:
    """Run what is missing, print, write."""
    effort = effort_of(options)
    jobs = jobs_of(options, effort)
    if options.only_kept:
        answers = kept(jobs, options.out)
    else:
        take_known(jobs, options.out)
        answers = run_sweep(jobs, options.out, workers=options.jobs, cluster=options.cluster, on_progress=say_answered)
        keep(jobs, answers)
    bars = Bars(answers, effort)
    figures = figures_of(bars) if answers else []
    figures += log_figures() if options.logs else []
    report("adaptation", figures, effort.seeds, options.json)
    if options.page:
        write_text(options.page, page(bars, [load_suite(name) for name in SUITES], figures))


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
