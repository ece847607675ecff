"""Whether a diagnosis says the same of the same drive: worlds turned and moved, logs cut, shuffled, recorded later,
every second row, another base.

Cases are single effects of the standard set in one of its sizes, drawn by seed. Bases come about as on the command
line, and logs go through files: what was learned at one step gets logs of another one resampled, first principles are
made at the logs' own step, with what a diagnosis of the healthy robot's runs adds to them.

    python tools/bench/invariance.py --cases 2
    python tools/bench/invariance.py --cases 60 --sealed --json build/invariance.json
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import tyro
from answers import ALONG_THE_WORLD, Record, first, same_first, within_both
from bases import Base, Kind, base_of, calibrated, diagnosed
from figures import Figure, report
from hidden_scores import first_right
from log_changes import CHANGES, drawn_turn
from repeated import Asked, OfRobots, print_table, share
from single_effects import hidden_case
from standard_cases import SERIES
from standard_set import Case, simulate_case

from sym2real.experiments.study.sweep import Tell
from sym2real.robots import ROBOTS

BENCH, PLAIN, OWN_STEP = "invariance", "as it is", "own step"
PRINCIPLES: Kind = "first principles"
# Name → what is done to the logs, with which base; the last makes first principles at the step of the changed logs.
CHANGED: dict[str, tuple[str, str]] = {
    PLAIN: ("", "simulator"),
    **{name: (name, "simulator") for name in CHANGES},
    "base from logs": ("", "logs"),
    "first principles": ("", PRINCIPLES),
    "half rate, first principles": ("half rate", OWN_STEP),
}


@dataclass(frozen=True)
class Options(OfRobots):
    """Diagnose the same cases in many disguises.

    Args:
        changes: disguises to try; the first answers what all others are held against.
    """

    changes: tuple[str, ...] = tuple(CHANGED)


def disguised(robot: str, changes: Sequence[str], bases: dict[str, Base], seed: int) -> Asked:
    """The case of a seed in all disguises."""
    case = hidden_case(robot, SERIES[robot], seed)
    asked = {"case": case.name, "changes": list(changes)}
    return Asked(f"{robot} {seed}", asked, partial(answer, case, changes, bases))


def answer(case: Case, changes: Sequence[str], bases: dict[str, Base], tell: Tell) -> Record:
    """An answer per disguise; also the angle by which the worlds were turned."""

    def rng() -> np.random.Generator:
        """The same draw for every disguise."""
        return np.random.default_rng([case.seed, 1])

    data, world, answers = simulate_case(case), tied_to_the_world(case), {}
    for name in changes:
        change, base = CHANGED[name]
        if change == "turned each" and world:
            continue
        tell(name)
        answers[name] = diagnosed(bases[base].equations, CHANGES[change](data, rng()) if change else data)
    truth = {key: dict(values) for key, values in case.effects}
    of = {"robot": case.robot, "yaw": case.yaw, "truth": truth, "excluded": []}
    return {**of, "angle": drawn_turn(rng()).angle, "answers": answers}


def tied_to_the_world(case: Case) -> bool:
    """Whether an effect has components along the world's axes."""
    return any({*pair} <= {*values} for _, values in case.effects for pair in ALONG_THE_WORLD)


def bases_of(options: Options, robot: str) -> dict[str, Base]:
    """Those that the chosen disguises need."""
    place = options.run.place(BENCH)
    needed = {CHANGED[name][1] for name in options.changes}
    learned: tuple[Kind, ...] = ("simulator", "logs")
    bases = {kind: base_of(robot, kind, place) for kind in learned if kind in needed}
    steps = {PRINCIPLES: ROBOTS[robot].dt, OWN_STEP: 2 * ROBOTS[robot].dt}
    written = {name: calibrated(base_of(robot, PRINCIPLES, place, dt)) for name, dt in steps.items() if name in needed}
    return bases | written


def figures(records: Sequence[Record], robot: str) -> list[Figure]:
    """Right as it is; the same, and within both intervals, in every disguise and in all."""
    own = [record for record in records if record["robot"] == robot]
    right = (first_right({**record, **record["answers"][PLAIN]}) for record in own)
    found = share(f"{robot}, as it is: first effect right", right, ">= 0.95")
    same: list[bool] = []
    within: list[bool] = []
    for name in (name for name in CHANGED if name != PLAIN):
        pairs = [(one, one["answers"][PLAIN], one["answers"][name]) for one in own if name in one["answers"]]
        alike = [same_first(plain, changed) for _, plain, changed in pairs]
        held = [
            flag
            for one, plain, changed in pairs
            for flag in within_both(plain, changed, one["angle"] if name == "turned" else 0.0)
        ]
        found += share(f"{robot}, {name}: same first effect or its group", alike)
        found += share(f"{robot}, {name}: values within both intervals", held)
        same, within = same + alike, within + held
    found += share(f"{robot}, all: same first effect or its group", same, ">= 0.95")
    return found + share(f"{robot}, all: values within both intervals", within, ">= 0.90")


def main(options: Options) -> None:
    """Simulate, diagnose, print, write."""
    seeds = options.run.seeds_of(BENCH)
    bases = {robot: bases_of(options, robot) for robot in options.robots}
    jobs = [disguised(robot, options.changes, bases[robot], seed) for robot in options.robots for seed in seeds]
    records = options.run.answers(BENCH, jobs)
    said = ((one["asked"]["case"], name, first(found)) for one in records for name, found in one["answers"].items())
    print_table("first finding in every disguise", ("case", "disguise", "found"), said)
    rows = [row for robot in options.robots for row in figures(records, robot)]
    report(BENCH, rows, seeds, options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
