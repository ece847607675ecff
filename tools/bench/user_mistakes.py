"""Mistakes of a user in the logs of a healthy robot: whether ``diagnose`` and ``compare`` name them.

The base is the one that the robot's name stands for; the logs are four runs of the standard set's null case, or eight
of a robot of joints (new_robots.py). A mistake is named
by a fault, a finding, a remark or a refusal (mistakes.py); confidently wrong is ``EFFECT`` without that, silent
``NOTHING_MISSING``. Logs without a mistake are asked too: what is said of them may name none of all. Fewer than the
list has are spread evenly over it.

    python tools/bench/user_mistakes.py --cases 8
    python tools/bench/user_mistakes.py --cases 40 --sealed --json build/user_mistakes.json
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import tyro
from answers import CRASHED, UNFORESEEN, Record, first, names, refusal, sentences
from bases import Base, as_read, base_of, diagnosed
from figures import Figure, report
from mistakes import Mistake
from mistakes_list import JOINTS, MISTAKES
from new_robots import logs
from repeated import Asked, OfRobots, print_table, share, spread_over
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.errors import Sym2RealError
from sym2real.experiments.study.sweep import Tell
from sym2real.symbolic import Equations

BENCH, HEALTHY = "user mistakes", "none"
RUNS = 4


@dataclass(frozen=True)
class Options(OfRobots):
    """Make mistakes in healthy logs.

    Args:
        only: only these mistakes, by name.
    """

    only: tuple[str, ...] = ()


def made(base: Base, mistake: str, seed: int) -> Asked:
    """One mistake, of a size that the seed draws."""
    asked = {"robot": base.robot, "mistake": mistake, "seed": seed}
    return Asked(f"{base.robot} {mistake} {seed}", asked, partial(answer, base, mistake, seed))


def answer(base: Base, mistake: str, seed: int, tell: Tell) -> Record:
    """What ``diagnose`` and ``compare`` say."""
    data, equations = healthy(base.robot, seed), base.equations
    if mistake != HEALTHY:
        data = listed(base.robot, mistake).made(data, seed)
    tell("diagnosing")
    found = diagnosed(equations, data)
    tell("comparing")
    return {"answer": found, "compare": compared(equations, data)}


def healthy(robot: str, seed: int) -> Dataset:
    """Logs in which nothing is wrong."""
    return logs(robot, seed) if robot in JOINTS else simulate_case(Case(robot, seed=seed, yaw=True), RUNS)


def listed(robot: str, name: str) -> Mistake:
    """The mistake of that name."""
    return next(one for one in MISTAKES[robot] if one.name == name)


def compared(equations: Equations, data: Dataset) -> list[str]:
    """What ``sym2real compare`` says of the logs themselves."""
    try:
        found = compare(equations, as_read(equations, data))
    except (Sym2RealError, *UNFORESEEN) as error:
        return sentences(refusal(error))
    return [*found.notes, *(() if found.data is None else found.data.lines())]


def judged(mistake: Mistake, answer: Record, said: Sequence[str]) -> Record:
    """How an answer stands to a mistake."""
    keys = [*names(answer), *(fault["effect"] for fault in answer["faults"])]
    named = mistake.named_in(keys, sentences(answer))
    return {
        "named": named,
        "wrong": answer["verdict"] == "EFFECT" and not named,
        "silent": answer["verdict"] == "NOTHING_MISSING" and not named,
        "crashed": answer["verdict"] == CRASHED,
        "beside": named and bool([key for key in names(answer) if not mistake.named_in([key], [])]),
        # An effect in its place, and what looks like it, is the search's to name.
        "of_the_data": mistake.named_in(
            [fault["effect"] for fault in answer["faults"]], sentences({**answer, "findings": []})
        ),
        "compare_names": mistake.named_in([], said),
    }


def chosen(options: Options, robot: str) -> Iterator[tuple[str, int]]:
    """Mistakes with a seed each."""
    known = [one.name for one in MISTAKES[robot] if not options.only or one.name in options.only]
    names = spread_over(known, options.run.cases)
    yield from zip(names, replace(options.run, cases=len(names)).seeds_of(BENCH), strict=False)


def verdicts(records: Sequence[Record]) -> list[Record]:
    """How each answer stands to its mistake; healthy logs have none."""
    pairs = ((one, one["asked"]) for one in records if one["asked"]["mistake"] != HEALTHY)
    return [judged(listed(of["robot"], of["mistake"]), one["answer"], one["compare"]) for one, of in pairs]


def named_in_healthy_logs(records: Sequence[Record]) -> list[bool]:
    """For every mistake, whether the answer to logs without any would count as naming it."""
    return [
        flags["named"] or flags["compare_names"]
        for one in records
        if one["asked"]["mistake"] == HEALTHY
        for flags in (judged(mistake, one["answer"], one["compare"]) for mistake in MISTAKES[one["asked"]["robot"]])
    ]


def figures(records: Sequence[Record]) -> list[Figure]:
    """One per bar, and how the rest ends."""
    rows = {
        "mistake named": ("named", ">= 0.85"),
        "confidently wrong": ("wrong", "<= 0.02"),
        "silent": ("silent", ""),
        "crashed": ("crashed", "<= 0"),
        "named, with effects beside that are not there": ("beside", ""),
    }
    judgements = verdicts(records)
    found = [row for name, (key, bar) in rows.items() for row in share(name, (one[key] for one in judgements), bar)]
    found += share(
        "compare says of the data what diagnose says",
        (one["compare_names"] == one["of_the_data"] for one in judgements),
        ">= 1",
    )
    return found + share("named in healthy logs, of all mistakes", named_in_healthy_logs(records), "<= 0")


def said(record: Record) -> Sequence[str]:
    """What was said of a mistake, and whether it is named by that."""
    found, asked = record["answer"], record["asked"]
    (verdict,) = verdicts([record]) or [{"named": True}]
    faults = "; ".join(fault["effect"] or fault["evidence"].partition(":")[0] for fault in found["faults"])
    return asked["robot"], asked["mistake"], str(verdict["named"]), found["verdict"], first(found), faults


def main(options: Options) -> None:
    """Simulate, spoil, diagnose, compare, print, write."""
    place, jobs = options.run.place(BENCH), list[Asked]()
    for robot in options.robots:
        base = base_of(robot, "simulator", place)
        jobs += [made(base, name, seed) for name, seed in chosen(options, robot)]
        jobs.append(made(base, HEALTHY, options.run.seeds_of(BENCH)[0]))
    records = options.run.answers(BENCH, jobs)
    print_table("what was said", ("robot", "mistake", "named", "verdict", "found", "faults"), map(said, records))
    report(BENCH, figures(records), sorted({job.asked["seed"] for job in jobs}), options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
