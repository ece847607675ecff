"""Whether a diagnosis says the same of the same drive: worlds turned and moved, logs cut, shuffled, recorded later,
every second row, another base.

Cases are single effects of the standard set in one of its sizes, drawn by seed. Bases come about as on the command
line, and logs go through files: what was learned at one step gets logs of another one resampled, first principles are
made at the logs' own step, with what a diagnosis of the healthy robot's runs adds to them.

    python tools/bench/invariance.py --cases 2
    python tools/bench/invariance.py --cases 60 --sealed --json build/invariance.json
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated

import numpy as np
import tyro
from answers import ALONG_THE_WORLD, Record, first, same_first, within_both
from bases import Base, Kind, base_of, calibrated, diagnosed
from figures import Figure, report
from hidden_scores import first_right
from log_changes import CHANGES, drawn_turn
from repeated import Settings, share
from rich.console import Console
from rich.table import Table
from single_effects import hidden_case
from standard_cases import SERIES
from standard_set import Case, simulate_case

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
class Options:
    """Diagnose the same cases in many disguises."""

    run: Annotated[Settings, tyro.conf.arg(name="")] = field(default_factory=Settings)
    robots: tuple[str, ...] = ("crazyflie", "mushr")
    """Robots to run."""
    changes: tuple[str, ...] = tuple(CHANGED)
    """Disguises to try; the first answers what all others are held against."""


@dataclass(frozen=True)
class Disguised:
    """A :class:`~sym2real.experiments.study.sweep.Job`: one case in all disguises."""

    case: Case
    changes: tuple[str, ...]
    bases: dict[str, Base]

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.case.robot}_{self.case.seed}"

    @property
    def asked(self) -> Record:
        """What the answer depends on."""
        return {"case": self.case.name, "changes": list(self.changes)}

    def run(self, tell: Callable[[str], None]) -> Record:
        """An answer per disguise; also the angle by which the worlds were turned."""
        data, world = simulate_case(self.case), tied_to_the_world(self.case)
        answers = {}
        for name in self.changes:
            change, base = CHANGED[name]
            if change == "turned each" and world:
                continue
            tell(name)
            changed = CHANGES[change](data, self._rng()) if change else data
            answers[name] = diagnosed(self.bases[base].equations, changed)
        truth = {key: dict(values) for key, values in self.case.effects}
        of = {"robot": self.case.robot, "yaw": self.case.yaw, "truth": truth, "excluded": []}
        return {**of, "angle": drawn_turn(self._rng()).angle, "answers": answers}

    def _rng(self) -> np.random.Generator:
        """The same draw for every disguise."""
        return np.random.default_rng([self.case.seed, 1])


def tied_to_the_world(case: Case) -> bool:
    """Whether an effect has components along the world's axes."""
    return any({*pair} <= {*values} for _, values in case.effects for pair in ALONG_THE_WORLD)


def job(robot: str, changes: Sequence[str], bases: dict[str, Base], seed: int) -> Disguised:
    """The case of a seed."""
    return Disguised(hidden_case(robot, SERIES[robot], seed), tuple(changes), bases)


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


def print_answers(records: Sequence[Record], console: Console) -> None:
    """The first finding in every disguise; red where it is not that of the first."""
    for record in records:
        table = Table(title=f"{record['robot']}: {record['truth']}", title_justify="left")
        table.add_column("disguise")
        table.add_column("first finding")
        for name, answer in record["answers"].items():
            good = same_first(record["answers"][PLAIN], answer)
            table.add_row(name, f"[{'green' if good else 'red'}]{first(answer)}[/]")
        console.print(table)


def main(options: Options) -> None:
    """Simulate, diagnose, print, write."""
    seeds = options.run.seeds_of(BENCH)
    jobs = []
    for robot in options.robots:
        jobs += list(map(partial(job, robot, options.changes, bases_of(options, robot)), seeds))
    records = options.run.answers(BENCH, jobs)
    print_answers(records, Console(stderr=True))
    rows = [row for robot in options.robots for row in figures(records, robot)]
    report(BENCH, rows, seeds, options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
