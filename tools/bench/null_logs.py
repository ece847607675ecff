"""False alarms in logs with nothing to find: at other rates than the model's, rows lost or repeated, one circle only.

The robot is controlled and logged at the rate; logs go through files as on the command line, which brings them to the
step of the base from the plain simulator. What is said of the damage itself is no alarm.

    python tools/bench/null_logs.py --cases 2
    python tools/bench/null_logs.py --cases 100 --sealed --json build/null_logs.json
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import tyro
from answers import REFUSED, Record, names
from bases import Base, base_of, diagnosed
from figures import Figure, report
from log_changes import taken
from repeated import Asked, OfRobots, print_table, share
from standard_set import Case, simulate_case

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.experiments.standard_conditions import sensors
from sym2real.experiments.study.sweep import Tell
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import ROBOTS, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Trajectory

BENCH = "null logs"
RATES = {f"{rate} Hz": float(rate) for rate in (16, 20, 25, 45, 100)}
SECONDS = {"crazyflie": 8.0, "mushr": 20.0}
LOST, LONGEST = 0.03, 3  # part of the rows at which rows begin to be lost, and how many in a row
CIRCLES = 6  # logs of one circle
STALE = 0.05  # part of the rows that repeat the state before
OF_DAMAGE = re.compile("lost|missing|gap|repeat|stale|duplicate|froze", re.IGNORECASE)


def with_lost_rows(data: Dataset, rng: np.random.Generator) -> Dataset:
    """Rows that never arrived, up to :data:`LONGEST` in a row; stamps tell."""
    return Dataset(taken(log, ~_runs(len(log), rng)) for log in data)


def _runs(rows: int, rng: np.random.Generator) -> np.ndarray:
    lost = np.zeros(rows, dtype=bool)
    for start in np.flatnonzero(rng.random(rows) < LOST):
        lost[start : start + int(rng.integers(1, LONGEST + 1))] = True
    lost[[0, -1]] = False
    return lost


def with_stale_rows(data: Dataset, rng: np.random.Generator) -> Dataset:
    """Rows whose whole state is that of the row before, as where the estimator was late."""

    def stale(log: Trajectory) -> Trajectory:
        fresh = rng.random(len(log)) >= STALE
        fresh[0] = True
        return replace(log, state=log.state[np.maximum.accumulate(np.where(fresh, np.arange(len(log)), 0))])

    return Dataset(stale(log) for log in data)


def circles(robot: Robot, seed: int) -> Dataset:
    """Logs of one and the same steady circle, in which rates hardly change."""
    task, found = make_task("circle", robot), list[Trajectory]()
    for log in range(CIRCLES):
        plant = MujocoPlant(robot, [sensors(robot, np.random.default_rng([seed, log]))])
        run = run_episode(plant, geometric_controller(robot, task.reference), task, steps=rows_of(robot))
        found.append(replace(run, name=f"circle_{log + 1}"))
    return Dataset(found)


def rows_of(robot: Robot) -> int:
    """Of one log."""
    return round(SECONDS[robot.name] / robot.dt)


DAMAGES = {"as it is": None, "rows lost": with_lost_rows, "rows repeated": with_stale_rows}
ONE_CIRCLE = "one circle"
KINDS = (*DAMAGES, ONE_CIRCLE, *RATES)


def null(base: Base, kind: str, seed: int) -> Asked:
    """One set of runs of a healthy robot."""
    asked = {"robot": base.robot, "kind": kind, "seed": seed}
    return Asked(f"{base.robot} {kind} {seed}", asked, partial(answer, base, kind, seed))


def answer(base: Base, kind: str, seed: int, tell: Tell) -> Record:
    """What a diagnosis says of it."""
    tell("simulating")
    robot = ROBOTS[base.robot]
    data = simulated(robot.at_period(1.0 / RATES[kind]) if kind in RATES else robot, kind, seed)
    tell("diagnosing")
    return diagnosed(base.equations, data)


def simulated(robot: Robot, kind: str, seed: int) -> Dataset:
    """The runs of a kind."""
    if kind == ONE_CIRCLE:
        return circles(robot, seed)
    data = simulate_case(Case(robot.name, seed=seed), rows=rows_of(robot), robot=robot)
    damage = DAMAGES.get(kind)
    return damage(data, np.random.default_rng([seed, 1])) if damage else data


def alarm(answer: Record) -> bool:
    """Whether something is said to be missing, or wrong with the data that is no damage to them."""
    faults = [fault for fault in answer["faults"] if not OF_DAMAGE.search(f"{fault['effect']} {fault['evidence']}")]
    missing = answer["verdict"] == "UNEXPLAINED" or (answer["verdict"] == "EFFECT" and bool(names(answer)))
    return missing or bool(faults)


def said(answer: Record) -> str:
    """Findings and faults."""
    return ", ".join([*names(answer), *(fault["effect"] or fault["evidence"] for fault in answer["faults"])])


def figures(records: Sequence[Record]) -> list[Figure]:
    """False alarms by robot and kind, and of all; refusals too."""
    found: list[Figure] = []
    for robot in dict.fromkeys(one["asked"]["robot"] for one in records):
        for kind in KINDS:
            own = [one for one in records if (one["asked"]["robot"], one["asked"]["kind"]) == (robot, kind)]
            found += share(f"{robot}, {kind}: false alarms", map(alarm, own))
    found += share("all: false alarms", map(alarm, records), "<= 0.01")
    return found + share("all: refused", (one["verdict"] == REFUSED for one in records))


def main(options: OfRobots) -> None:
    """Simulate, diagnose, print, write."""
    place, seeds = options.run.place(BENCH), options.run.seeds_of(BENCH)
    bases = [base_of(robot, "simulator", place) for robot in options.robots]
    jobs = [null(base, kind, seed) for seed in seeds for base in bases for kind in KINDS]
    records = options.run.answers(BENCH, jobs)
    alarms = ((*map(str, one["asked"].values()), one["verdict"], said(one)) for one in filter(alarm, records))
    print_table("alarms", ("robot", "kind", "seed", "verdict", "said"), alarms)
    report(BENCH, figures(records), seeds, options.run.json)


if __name__ == "__main__":
    main(tyro.cli(OfRobots, description=__doc__))
