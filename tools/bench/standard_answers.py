"""What follows a right answer on the standard set: ``add X --fit`` of every true effect, and the found model diagnosed
again, on the same logs and on logs with one more effect.

Cases are single effects, spread evenly over the set; sealed ones have other noise, trim and axes. With ``--results``
answers of ``hidden_effects.py`` are taken where they are there.

    python tools/bench/standard_answers.py --cases 2
    python tools/bench/standard_answers.py --cases 60 --results build/hidden.jsonl
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from answers import Record, named, names, stands_for
from bases import Base, base_of, diagnosed
from figures import Figure, report
from null_logs import alarm
from repeated import Settings, share
from rich.console import Console
from rich.table import Table
from standard_cases import standard_cases
from standard_set import Case, simulate_case

from sym2real.cli.found import plain_simulator
from sym2real.diagnosis import add, try_effect
from sym2real.effects import same_group
from sym2real.symbolic import Equations

BENCH = "standard answers"


@dataclass(frozen=True)
class Options:
    """Ask on after a diagnosis."""

    run: Annotated[Settings, tyro.conf.arg(name="")] = field(default_factory=Settings)
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    """Robots to run."""
    results: Path | None = None
    """Answers of hidden_effects.py to reuse."""


@dataclass(frozen=True)
class Followed:
    """A :class:`~sym2real.experiments.study.sweep.Job`: one case with all that follows.

    Args:
        base: of the robot.
        case: with one effect.
        more: a second effect with its values, from another case.
        answer: of ``diagnose``, if it is known already.
    """

    base: Base
    case: Case
    more: tuple[str, dict[str, float]]
    answer: Record | None

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.case.robot}_{self.case.keys[0].replace(':', '_')}_{self.case.seed}"

    @property
    def asked(self) -> Record:
        """What the answer depends on."""
        return {"case": self.case.name, "more": self.more[0]}

    def run(self, tell: Callable[[str], None]) -> Record:
        """All four answers."""
        (key,), equations, data = self.case.keys, self.base.equations, simulate_case(self.case)
        tell("fitting")
        tried = try_effect(equations, key, data, plain_simulator(equations))
        tell("diagnosing")
        answer = self.answer or diagnosed(equations, data)
        tell("diagnosing what was found")
        informed = with_findings(equations, answer)
        again = diagnosed(informed, data)
        tell("diagnosing one more")
        both = replace(self.case, effects=(*self.case.effects, self.more))
        further = diagnosed(informed, simulate_case(both))
        alike = any(one.as_good and not same_group(one.effect, key) for one in tried.rivals)
        fit = {"supported": tried.supported, "alike": alike, "gain": tried.gain}
        return {
            **{"robot": self.case.robot, "truth": key, "more": self.more[0], "fit": fit},
            **{"answer": answer, "again": again, "further": further},
        }


def with_findings(equations: Equations, answer: Record) -> Equations:
    """The model that a diagnosis leaves."""
    found = [
        (one["effect"], {name: estimate["value"] for name, estimate in one["parameters"].items()})
        for one in answer["findings"]
    ]
    return add(equations, found) if found else equations


def chosen(options: Options, robot: str) -> Iterator[tuple[Case, tuple[str, dict[str, float]]]]:
    """Cases, each with a second effect that is no equivalent of its own."""
    singles = [case for case in standard_cases(robot) if len(case.effects) == 1]
    count = min(options.run.cases, len(singles))
    cases = [singles[place] for place in np.unique(np.linspace(0, len(singles) - 1, count).round().astype(int))]
    if options.run.sealed or options.run.seeds:
        seeds = replace(options.run, cases=count).seeds_of(BENCH)
        cases = [replace(case, seed=seed) for case, seed in zip(cases, seeds, strict=False)]
    for case in cases:
        others = [one for one in singles if not same_group(one.keys[0], case.keys[0])]
        key, values = others[int(np.random.default_rng(case.seed).integers(len(others)))].effects[0]
        yield case, (key, dict(values))


def kept(results: Path | None) -> dict[str, Record]:
    """Answers of ``hidden_effects.py`` by the case's name; none without a file."""
    if results is None:
        return {}
    lines = [json.loads(line) for line in results.read_text().splitlines() if line.endswith("}")]
    return {one["name"].removeprefix("single: "): one for one in lines if one["kind"] == "single"}


def consistent(record: Record) -> bool:
    """Whether ``diagnose`` names an effect that ``add --fit`` supports with no rival as good."""
    return named(record["answer"], record["truth"])


def adds_it(record: Record) -> bool:
    """Whether what is found further stands for the effect that came in addition."""
    return any(stands_for(one, record["more"]) for one in record["further"]["findings"])


def figures(records: Sequence[Record]) -> list[Figure]:
    """One per bar."""
    alone = [one for one in records if one["fit"]["supported"] and not one["fit"]["alike"]]
    return [
        *share("add X --fit of the true effect: supported", (one["fit"]["supported"] for one in records), ">= 0.95"),
        *share("supported and nothing as good: diagnose names it or its group", map(consistent, alone), ">= 1"),
        *share("the found model, again: nothing new", (not alarm(one["again"]) for one in records), ">= 0.95"),
        *share("the found model, one more effect: that one named", map(adds_it, records), ">= 0.90"),
    ]


def print_answers(records: Sequence[Record], console: Console) -> None:
    """What was said at every step."""
    table = Table(title="what was said", title_justify="left")
    for heading in ("robot", "truth", "add --fit", "diagnose", "again", "one more", "named"):
        table.add_column(heading, overflow="fold")
    for one in records:
        fit = f"{'supported' if one['fit']['supported'] else 'not supported'} {one['fit']['gain']:.2f}"
        said = [", ".join(names(one[step])) or one[step]["verdict"] for step in ("answer", "again", "further")]
        table.add_row(one["robot"], one["truth"], fit, said[0], said[1], one["more"], said[2])
    console.print(table)


def main(options: Options) -> None:
    """Simulate, fit, diagnose, print, write."""
    known, jobs = kept(options.results), []
    for robot in options.robots:
        base = base_of(robot, "simulator", options.run.place(BENCH))
        jobs += [Followed(base, case, more, known.get(case.name)) for case, more in chosen(options, robot)]
    records = options.run.answers(BENCH, jobs)
    print_answers(records, Console(stderr=True))
    report(BENCH, figures(records), sorted({job.case.seed for job in jobs}), options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
