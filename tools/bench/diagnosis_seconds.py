"""CPU seconds and memory of ``diagnose`` on cases of the standard set, and whether answers stayed what they were.

The machine may do other work, so the process's own seconds count; cases run one after the other, so that what is kept
from one to the next counts as in a session with many logs. ``--results FILE`` keeps the answers; ``--before FILE``
holds them against those that another version has left there.

    python tools/bench/diagnosis_seconds.py --cases 10 --results build/seconds.jsonl
    python tools/bench/diagnosis_seconds.py --cases 10 --before build/seconds.jsonl
"""

from __future__ import annotations

import json
import os
import re
import resource
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from answers import Record, answer_of, names
from figures import Figure, report
from hidden_effects import Options as Set
from hidden_effects import base_of, questions
from hidden_question import Question
from rich.console import Console
from rich.table import Table
from standard_set import simulate_case

from sym2real.diagnosis import diagnose
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS

BENCH = "seconds of a diagnosis"
# What two runs of one version differ by: how long they took.
UNLIKE = ("seconds", "cpu", "memory")


@dataclass(frozen=True)
class Options:
    """Time diagnoses, and compare what they say."""

    cases: int = 10
    """Questions, spread evenly over the quick standard set."""
    only: str = ""
    """Instead those whose name this regular expression finds."""
    results: Path | None = None
    """Write every answer to this file, one JSON line each."""
    before: Path | None = None
    """Answers of another version."""
    json: Path | None = None
    """Write the figures to this file (- is standard output)."""


def chosen(options: Options) -> list[Question]:
    """The questions of a run."""
    asked = questions(Set(quick=True))
    if options.only:
        return [one for one in asked if re.search(options.only, one.name)]
    places = np.linspace(0, len(asked) - 1, min(options.cases, len(asked))).round().astype(int)
    return [asked[place] for place in np.unique(places)]


def timed(question: Question) -> Record:
    """An answer with its CPU seconds, those of the compiler included, and the process's memory so far."""
    case, equations = question.case, base_of(question.case.robot)
    data, plant, before = simulate_case(case), MujocoPlant(ROBOTS[case.robot]), sum(os.times()[:4])
    found = diagnose(equations, data, plant, exclude=question.exclude)
    cpu, memory = sum(os.times()[:4]) - before, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return {"name": question.name, **answer_of(found), "cpu": cpu, "memory": memory}


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


def main(options: Options) -> None:
    """Ask, print, compare."""
    lines = options.before.read_text().splitlines() if options.before else []
    before = {record["name"]: record for record in map(json.loads, lines)}
    table = Table("case", "says", "CPU s", "before", "GB", "largest difference", title_justify="left")
    records = []
    for question in chosen(options):
        record = timed(question)
        records.append(record)
        if options.results is not None:
            with options.results.open("a") as file:
                file.write(json.dumps(record) + "\n")
        old = before.get(question.name)
        found = max(differences(old, record), key=lambda entry: entry[1], default=("none", 0.0)) if old else ("", 0.0)
        said = ", ".join(names(record)) or record["verdict"]
        cells = [f"{record['cpu']:.1f}", f"{old['cpu']:.1f}" if old else "", f"{record['memory']:.2f}"]
        table.add_row(question.name, said, *cells, f"{found[0]} {found[1]:.0e}" if found[1] else found[0])
        print(f"{len(records)} {question.name} → {said} ({record['cpu']:.1f} s) {found}", flush=True)
    Console(stderr=options.json == Path("-")).print(table)
    seconds = [record["cpu"] for record in records]
    rows = [
        Figure("CPU seconds of a diagnosis, median", float(np.median(seconds)), "s"),
        Figure("CPU seconds of a diagnosis, longest", max(seconds), "s"),
        Figure("memory of the process", max(record["memory"] for record in records), "GB"),
    ]
    report(BENCH, rows, [], options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
