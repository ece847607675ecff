"""What follows a right answer on the standard set: ``add X --fit`` of every true effect, and the found model diagnosed
again, on the same logs and on logs with one more effect.

Cases are single effects, spread evenly over the set; sealed ones have other noise, trim and axes.

    python tools/bench/standard_answers.py --cases 2
    python tools/bench/standard_answers.py --cases 60 --sealed
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import tyro
from answers import Record, named, names, same_group, with_findings
from bases import Base, base_of, diagnosed
from figures import Figure, report
from null_logs import alarm
from repeated import Asked, OfRobots, print_table, share, spread_over
from standard_cases import standard_cases
from standard_set import Case, simulate_case

from sym2real.cli.results import plain_simulator
from sym2real.diagnosis import try_effect
from sym2real.experiments.study.sweep import Tell

BENCH = "standard answers"


def followed(base: Base, case: Case, more: tuple[str, dict[str, float]]) -> Asked:
    """One case with all that follows.

    Args:
        base: of the robot.
        case: with one effect.
        more: a second effect with its values, from another case.
    """
    asked = {"case": case.name, "more": more[0]}
    return Asked(f"{case.robot} {case.keys[0]} {case.seed}", asked, partial(answers, base, case, more))


def answers(base: Base, case: Case, more: tuple[str, dict[str, float]], tell: Tell) -> Record:
    """All four answers."""
    (key,), equations, data = case.keys, base.equations, simulate_case(case)
    tell("fitting")
    tried = try_effect(equations, key, data, plain_simulator(equations))
    tell("diagnosing")
    answer = diagnosed(equations, data)
    tell("diagnosing what was found")
    informed = with_findings(equations, answer)
    again = diagnosed(informed, data)
    tell("diagnosing one more")
    both = replace(case, effects=(*case.effects, more))
    further = diagnosed(informed, simulate_case(both))
    alike = any(one.as_good and not same_group(one.effect, key) for one in tried.rivals)
    fit = {"supported": tried.supported, "alike": alike, "gain": tried.gain}
    return {
        **{"robot": case.robot, "truth": key, "more": more[0], "fit": fit},
        **{"answer": answer, "again": again, "further": further},
    }


def chosen(options: OfRobots, robot: str) -> Iterator[tuple[Case, tuple[str, dict[str, float]]]]:
    """Cases, each with a second effect that is no equivalent of its own."""
    singles = [case for case in standard_cases(robot) if len(case.effects) == 1]
    cases = spread_over(singles, options.run.cases)
    if options.run.sealed or options.run.seeds:
        seeds = replace(options.run, cases=len(cases)).seeds_of(BENCH)
        cases = [replace(case, seed=seed) for case, seed in zip(cases, seeds, strict=False)]
    for case in cases:
        others = [one for one in singles if not same_group(one.keys[0], case.keys[0])]
        key, values = others[int(np.random.default_rng(case.seed).integers(len(others)))].effects[0]
        yield case, (key, dict(values))


def figures(records: Sequence[Record]) -> list[Figure]:
    """One per bar."""
    alone = [one for one in records if one["fit"]["supported"] and not one["fit"]["alike"]]
    quiet = (not alarm(one["again"]) for one in records)
    further = (named(one["further"], one["more"]) for one in records)
    return [
        *share("add X --fit of the true effect: supported", (one["fit"]["supported"] for one in records), ">= 0.95"),
        *share(
            "supported and nothing as good: diagnose names it or its group",
            (named(one["answer"], one["truth"]) for one in alone),
            ">= 1",
        ),
        *share("the found model, again: nothing new", quiet, ">= 0.95"),
        *share("the found model, one more effect: that one named", further, ">= 0.90"),
    ]


def said(record: Record) -> Sequence[str]:
    """What was said at every step."""
    fit = f"{'supported' if record['fit']['supported'] else 'not supported'} {record['fit']['gain']:.2f}"
    steps = (", ".join(names(record[step])) or record[step]["verdict"] for step in ("answer", "again", "further"))
    return record["robot"], record["truth"], fit, record["more"], *steps


def main(options: OfRobots) -> None:
    """Simulate, fit, diagnose, print, write."""
    jobs = []
    for robot in options.robots:
        base = base_of(robot, "simulator", options.run.place(BENCH))
        jobs += [(case.seed, followed(base, case, more)) for case, more in chosen(options, robot)]
    records = options.run.answers(BENCH, [job for _, job in jobs])
    headings = ("robot", "truth", "add --fit", "one more", "diagnose", "again", "with one more")
    print_table("what was said", headings, map(said, records))
    report(BENCH, figures(records), sorted({seed for seed, _ in jobs}), options.run.json)


if __name__ == "__main__":
    main(tyro.cli(OfRobots, description=__doc__))
