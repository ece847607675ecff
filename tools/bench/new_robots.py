"""Robots that are one file each: five hidden effects of every one, and logs of healthy ones.

Each effect is drawn by seed among those that ``plan`` sees in the healthy robot's noisy logs, and is twice as large as
the smallest that it says is seen; a case is eight runs of 400 rows. Right is a first finding that is the effect, stands
for it by physics, or is one that ``plan`` said beforehand these logs cannot tell from it.

    python tools/bench/new_robots.py --cases 1 --robots cart_pole
    python tools/bench/new_robots.py --sealed --cases 10 --json build/new_robots.json
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf
from typing import Any

import numpy as np
import tyro
from answers import UNFORESEEN, Record, answer_of, first, refusal, stands_for
from figures import Figure, report
from repeated import Asked, Run, Settings, print_table, share

from sym2real.dataset import Dataset
from sym2real.diagnosis import Visible, diagnose, plan
from sym2real.effects import effect
from sym2real.errors import Sym2RealError
from sym2real.experiments.noisy_runs import Effects, noisy_runs
from sym2real.experiments.study.sweep import Tell
from sym2real.robots import ROBOTS
from sym2real.tasks import make_task

BENCH, HIDDEN, LARGER = "new robots", 5, 2.0
LATER = 500_000  # seeds between the logs of a plan and those of a diagnosis
LEFT_OUT = ("sensor_", "time_shift", "limit", "rate_limit")
REACH = {"waist": 0.5, "shoulder": 0.4, "elbow": 0.4, "forearm_roll": 0.5, "wrist_bend": 0.5, "wrist_roll": 0.5}
PATHS = (("circle", {}), ("lemniscate", {}))
Tasks = Sequence[tuple[str, Mapping[str, Any]]]


@dataclass(frozen=True)
class Options:
    """Hidden effects of robots that are one file each; ten cases are five hidden effects and ten healthy robots.

    Args:
        robots: which ones.
    """

    run: Run = field(default_factory=Settings)
    robots: tuple[str, ...] = ("hexarotor", "cart_pole", "differential_drive", "arm")


def _posture(side: float) -> Mapping[str, Any]:
    start = dict(zip(ROBOTS["arm"].layouts.state, ROBOTS["arm"].start, strict=True))
    return {"goal": {joint: float(start[joint] + side * reach) for joint, reach in REACH.items()}}


def tasks_of(robot: str) -> Tasks:
    """What a robot does in its logs."""
    if robot == "arm":
        return [("regulate", _posture(side)) for side in (1.0, -1.0)]
    if robot == "cart_pole":
        return [("regulate", {"goal": {"slider": place}}) for place in (0.3, -0.3)]
    return PATHS if robot == "hexarotor" else (*PATHS, ("circle", {"clockwise": True, "radius": 0.8, "speed": 0.6}))


def logs(robot: str, seed: int, effects: Effects = ()) -> Dataset:
    """Eight noisy runs of 400 rows."""
    tasks = [make_task(name, ROBOTS[robot], **options) for name, options in tasks_of(robot)]
    return noisy_runs(ROBOTS[robot], tasks, effects, dither=2.5, seed=seed)


def draw(robot: str, seed: int, seen: Sequence[Visible]) -> tuple[str, dict[str, float], list[str]]:
    """An effect, its value, and what these logs cannot tell from it.

    The kind is drawn first, so that a robot of many joints is not all friction; then a joint, an actuator or an axis.
    Sensors are left out, and limits, which have no size to be doubled.
    """
    own = [row for row in seen if not row.effect.startswith(LEFT_OUT) and _values(robot, row)]
    rng = np.random.default_rng([seed, 1])
    kinds = sorted({row.effect.partition(":")[0].partition(" ")[0] for row in own})
    kind = kinds[rng.integers(len(kinds))]
    rows = [row for row in own if row.effect.partition(":")[0].partition(" ")[0] == kind]
    row = rows[rng.integers(len(rows))]
    key, _, choice = row.effect.partition(" ")  # of a rotor
    parameters = effect(key, ROBOTS[robot]).parameters
    chosen = {parameter.name: float(choice) for parameter in parameters if choice and not parameter.fitted}
    return key, {**chosen, row.parameter: float(rng.choice(_values(robot, row)))}, [*row.like, *row.always]


def _values(robot: str, row: Visible) -> list[float]:
    """On both sides of none, as large as a draw asks for, as far as that is likely."""
    parameters = effect(row.effect.partition(" ")[0], ROBOTS[robot]).parameters
    known = next(parameter for parameter in parameters if parameter.name == row.parameter)
    size = LARGER * (inf if row.smallest is None else row.smallest)
    return [value for value in (known.null - size, known.null + size) if known.low <= value <= known.high]


def judged(robot: str, seed: int, hidden: bool) -> Asked:
    """One robot's logs with a hidden effect, or without."""
    asked = {"robot": robot, "seed": seed, "hidden": hidden}
    return Asked(f"{robot} {'hidden' if hidden else 'null'} {seed}", asked, partial(answer, robot, seed, hidden))


def answer(robot: str, seed: int, hidden: bool, tell: Tell) -> Record:
    """The truth and the answer."""
    base, truth, alike = ROBOTS[robot].nominal(), dict[str, dict[str, float]](), list[str]()
    if hidden:
        tell("planning")
        key, value, alike = draw(robot, seed, plan(base, logs(robot, seed)).visible)
        truth = {key: value}
    tell("diagnosing")
    try:
        found = answer_of(diagnose(base, logs(robot, seed + LATER, list(truth.items()))))
    except (Sym2RealError, *UNFORESEEN) as error:
        found = refusal(error)
    return {"truth": truth, "alike": alike, "answer": found}


def right(record: Record) -> bool:
    """Whether the first finding is the effect, or one that nothing in these logs tells from it."""
    (key,), findings = record["truth"], record["answer"]["findings"]
    return bool(findings) and (stands_for(findings[0], key) or findings[0]["effect"] in record["alike"])


def in_its_group(record: Record) -> bool:
    """The same, or the answer itself says that it could be the effect."""
    (key,), findings = record["truth"], record["answer"]["findings"]
    return right(record) or (bool(findings) and key in findings[0]["group"])


def figures(records: Sequence[Record]) -> list[Figure]:
    """Hidden effects, all and by robot; false findings of healthy robots."""
    hidden = [one for one in records if one["asked"]["hidden"]]
    healthy = [one for one in records if not one["asked"]["hidden"]]
    found = share("first effect right", map(right, hidden), ">= 0.9")
    found += share("first effect right, or in the group that the answer gives", map(in_its_group, hidden))
    found += share("healthy robots with a finding", (bool(one["answer"]["findings"]) for one in healthy), "<= 0.025")
    for robot in dict.fromkeys(one["asked"]["robot"] for one in records):
        own = [one for one in hidden if one["asked"]["robot"] == robot]
        found += share(f"{robot}: first effect right", map(right, own))
    return found


def main(options: Options) -> None:
    """Simulate, diagnose, print, write."""
    seeds, robots = options.run.seeds_of(BENCH), options.robots
    jobs = [judged(robot, seed, True) for robot in robots for seed in seeds[:HIDDEN]]
    jobs += [judged(robot, seed, False) for robot in robots for seed in seeds]
    records = options.run.answers(BENCH, jobs)
    said = (map(str, (*one["asked"].values(), one["truth"], first(one["answer"]))) for one in records)
    print_table("first finding", ("robot", "seed", "hidden", "truth", "found"), said)
    report(BENCH, figures(records), seeds, options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
