"""Figures of the diagnosis on the standard set: hidden effects in MuJoCo, which it has to name from eight noisy logs.

The base model is the learned one (three episodes of Stage I, five drives); the truth is injected by MuJoCo's own means;
the diagnosis sees neither the label nor the plant that flew. Every answer is kept in the folder, and a run that was
stopped goes on from it; ``--before FOLDER`` holds the answers against those that another version has left there.

    python tools/bench/hidden_effects.py --quick
    python tools/bench/hidden_effects.py --folder build/hidden --json build/hidden_effects.json
    python tools/bench/hidden_effects.py --quick --cases 10 --no-control --folder build/now --before build/earlier
"""

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro
from answers import Record, first
from bases import base_of
from figures import Figure, report
from hidden_control import control_figures
from hidden_question import Question
from hidden_scores import figures
from repeated import answers_of, print_table, spread, spread_over
from standard_cases import standard_cases

from sym2real.effects import equivalents
from sym2real.experiments.study.sweep import answer_file

# Of a robot's cases without an effect so many are asked with each seed of those with one.
NULLS_A_ROUND = 25
# Flights with MPPI for each model in the full size.
FLIGHTS = 3
# What two runs of one version differ by: how long they took.
UNLIKE = ("seconds", "diagnosing", "cpu", "memory")


@dataclass(frozen=True)
class Options:
    """Run the diagnosis on the standard set.

    Args:
        quick: middle magnitudes, two seeds, twenty null cases a robot.
        robots: robots to run.
        only: only questions whose name this regular expression finds.
        cases: only so many questions, spread evenly over all.
        jobs: cases that run at the same time, each on one thread.
        control: also fly three effects a robot with MPPI: base, what was found, truth.
        folder: every answer is kept here. Another version needs another folder.
        before: folder with the answers of another version.
        json: write the figures to this file (- is standard output).
    """

    quick: bool = False
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    only: str = ""
    cases: int = 0
    jobs: int = 2
    control: bool = True
    folder: Path = Path("build/bench/hidden_effects")
    before: Path | None = None
    json: Path | None = None


def questions(options: Options) -> list[Question]:
    """All of a run, round by round: a part of a run has a seed of every effect and size, and some without effect."""
    found: list[Question] = []
    for robot in options.robots:
        cases = standard_cases(robot, options.quick)
        found += [Question(case) for case in cases]
        # The first seed of every effect and size is also asked without the effect, or one of two, in the library.
        alike = {Question(case).alike: case for case in reversed(cases) if case.effects}
        found += [Question(case, (key, *equivalents(key))) for case in alike.values() for key in case.keys]
    rounds, seen = dict[str, int](), Counter[object]()
    for one in found:
        rounds[one.title] = seen[one.alike] // (1 if one.case.effects else NULLS_A_ROUND)
        seen[one.alike] += 1
    ordered = sorted(found, key=lambda one: (rounds[one.title], not one.case.effects))
    wanted = [one for one in ordered if re.search(options.only, one.title)]
    return spread_over(wanted, options.cases or len(wanted))


def differences(one: Any, other: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Where two answers differ, and by what part of the larger number; infinitely where they are no two numbers."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        for key in one.keys() - set(UNLIKE):
            yield from differences(one[key], other[key], f"{place}.{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for number, pair in enumerate(zip(one, other, strict=True)):
            yield from differences(*pair, f"{place}[{number}]")
    elif one != other:
        numbers = isinstance(one, float) and isinstance(other, float)
        yield place, abs(one - other) / max(abs(one), abs(other)) if numbers else float("inf")


def changed(record: Record, name: str, before: Path | None) -> str:
    """The largest difference of an answer from another version's."""
    if before is None or not answer_file(before, name).exists():
        return ""
    earlier = json.loads(answer_file(before, name).read_text())
    place, size = max(differences(earlier, record), key=lambda entry: entry[1], default=("none", 0.0))
    return f"{place} {size:.0e}" if size else place


def main(options: Options) -> None:
    """Ask, print, write."""
    bases = {robot: base_of(robot, "simulator", options.folder) for robot in options.robots}
    jobs = [question.job(bases[question.case.robot]) for question in questions(options)]
    records = answers_of(jobs, options.folder, options.jobs)
    said = (
        (job.title, first(one), f"{one['cpu']:.1f}", str(len(one["findings"])), changed(one, job.name, options.before))
        for job, one in zip(jobs, records, strict=True)
    )
    print_table("what was found", ("question", "first", "CPU s", "findings", "largest difference"), said)
    rows = [figure for robot in options.robots for figure in figures(records, robot)]
    rows += spread("CPU time of a diagnosis", [one["cpu"] for one in records], "s", "<= 3")
    rows.append(Figure("CPU time of a diagnosis: longest", max(one["cpu"] for one in records), "s", "<= 30"))
    rows.append(Figure("memory of the process", max(one["memory"] for one in records), "GB", "<= 3"))
    if options.control:
        flights = 1 if options.quick else FLIGHTS
        for robot in options.robots:
            rows += control_figures(records, robot, bases[robot].equations, flights)
    report("hidden effects", rows, sorted({job.asked["seed"] for job in jobs}), options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
