"""Figures of the diagnosis on the standard set: hidden effects in MuJoCo, which it has to name from eight noisy logs.

The base model is the learned one (three episodes of Stage I, five drives); the truth is injected by MuJoCo's own means;
the diagnosis sees neither the label nor the plant that flew. With ``--results FILE`` every answer is kept there as one
line, and a run that was stopped goes on from it.

    python tools/bench/hidden_effects.py --quick
    python tools/bench/hidden_effects.py --results build/hidden.jsonl --json build/hidden_effects.json
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import tyro
from figures import report
from hidden_control import control_figures
from hidden_question import Question, answer
from hidden_scores import Record, confusion, figures, right
from joblib import Parallel, delayed
from rich.console import Console
from rich.table import Table
from standard_cases import standard_cases

from sym2real.effects import equivalents
from sym2real.experiments.models import cached_base
from sym2real.files import write_text
from sym2real.layout import Layout
from sym2real.robots import ROBOTS
from sym2real.symbolic import Equations
from sym2real.vocabulary import WRENCH

# Of a robot's cases without an effect so many are asked with each seed of those with one.
NULLS_A_ROUND = 25
# Flights with MPPI for each model in the full size.
FLIGHTS = 3


@dataclass(frozen=True)
class Options:
    """Run the diagnosis on the standard set."""

    quick: bool = False
    """Middle magnitudes, two seeds, twenty null cases a robot."""
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    """Robots to run."""
    effects: tuple[str, ...] = ()
    """Only cases with one of these effects, and none without an effect."""
    jobs: int = 2
    """Cases that run at the same time, each on one thread."""
    wrench: bool = True
    """With the base's wrench inputs; without them effects push approximately, as into equations fitted to logs."""
    control: bool = True
    """Also fly three effects a robot with MPPI: base, what was found, truth."""
    results: Path | None = None
    """Keep every answer in this file, one JSON line each, and go on from what is there."""
    json: Path | None = None
    """Write the figures to this file (- is standard output)."""


def questions(options: Options) -> list[Question]:
    """All of a run, round by round: a part of a run has a seed of every effect and size, and some without effect."""
    found: list[Question] = []
    for robot in options.robots:
        cases = [
            case
            for case in standard_cases(robot, options.quick)
            if not options.effects or set(case.keys) & set(options.effects)
        ]
        found += [Question(case) for case in cases]
        # The first seed of every effect and size is also asked without the effect, or one of two, in the library.
        first = {Question(case).alike: case for case in reversed(cases) if case.effects}
        found += [Question(case, (key, *equivalents(key))) for case in first.values() for key in case.keys]
    rounds, seen = dict[str, int](), Counter[object]()
    for one in found:
        rounds[one.name] = seen[one.alike] // (1 if one.case.effects else NULLS_A_ROUND)
        seen[one.alike] += 1
    return sorted(found, key=lambda one: (rounds[one.name], not one.case.effects))


@lru_cache(maxsize=2)
def base_of(robot: str) -> Equations:
    """The learned base: three episodes of Stage I for the quadrotor, five drives for the car, and pushed runs."""
    return cached_base(ROBOTS[robot])


def without_wrench(base: Equations) -> Equations:
    """The same motion where nothing pushes, in equations that no push can enter."""
    names = [name for name in base.layouts.inputs if name in WRENCH]
    inputs = Layout.of([name for name in base.layouts.inputs if name not in WRENCH])
    changed = base.substitute(dict.fromkeys(names, 0.0))
    return replace(changed, layouts=replace(base.layouts, inputs=inputs))


def answers(options: Options) -> Iterator[Record]:
    """Answers that are kept already, then the others as they come."""
    kept = _kept(options.results)
    asked = questions(options)
    yield from (kept[question.name] for question in asked if question.name in kept)
    rest = [question for question in asked if question.name not in kept]
    bases = {robot: base_of(robot) for robot in {one.case.robot for one in rest}}
    bases = bases if options.wrench else {robot: without_wrench(base) for robot, base in bases.items()}
    texts = {robot: base.to_json() for robot, base in bases.items()}
    runs = (delayed(answer)(question, texts[question.case.robot]) for question in rest)
    for number, record in enumerate(Parallel(n_jobs=options.jobs, return_as="generator_unordered")(runs), 1):
        said = ", ".join(finding["effect"] for finding in record["findings"]) or record["verdict"]
        print(
            f"{number}/{len(rest)} {record['name']} → {said} ({record['seconds']:.0f} s)", file=sys.stderr, flush=True
        )
        if options.results is not None:
            with options.results.open("a") as file:
                file.write(json.dumps(record) + "\n")
        yield record


def _kept(results: Path | None) -> dict[str, Record]:
    if results is None:
        return {}
    lines = results.read_text().splitlines(keepends=True) if results.exists() else []
    # A run that was killed may have left half a line.
    complete = [line for line in lines if line.endswith("}\n")]
    write_text(results, "".join(complete))
    return {record["name"]: record for record in map(json.loads, complete)}


def print_confusion(records: Sequence[Record], robot: str, console: Console) -> None:
    """First findings by truth; green where they count as right."""
    table = Table(title=f"{robot}: first finding by truth", title_justify="left")
    table.add_column("truth")
    table.add_column("said", overflow="fold")
    for truth, counts in confusion(records, robot).items():
        key, yaw = truth.removesuffix(" (yaw)"), truth.endswith(" (yaw)")
        parts = []
        for said, count in counts.most_common():
            good = said == key == "nothing" or (
                key != "nothing" and said != "nothing" and right({"yaw": yaw}, key, said)
            )
            parts.append(f"[{'green' if good else 'red'}]{said} {count}[/]")
        table.add_row(truth, ", ".join(parts))
    console.print(table)


def main(options: Options) -> None:
    """Ask, print, write."""
    records = list(answers(options))
    console = Console(stderr=options.json == Path("-"))
    for robot in options.robots:
        print_confusion(records, robot, console)
    rows = [figure for robot in options.robots for figure in figures(records, robot)]
    if options.control:
        flights = 1 if options.quick else FLIGHTS
        for robot in options.robots:
            rows += control_figures(records, robot, base_of(robot), flights)
    seeds = sorted({question.case.seed for question in questions(options)})
    report("hidden effects", rows, seeds, options.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
