"""A car driven for 3 s at a time that has play, an offset, a delay, an arm and a speed map of its own, all at once.

Twenty drives a draw (short_drives.py), each effect twice as large as ``plan`` says can be seen, at 20 and at 40 Hz,
against a base from the plain simulator, which gets logs of 40 Hz resampled, and against first principles.

    python tools/bench/car_draws.py --cases 1
    python tools/bench/car_draws.py --cases 20 --sealed --json build/car_draws.json
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import tyro
from answers import Record, all_named, named, names
from bases import Base, Kind, base_of, diagnosed
from figures import Figure, report
from repeated import Settings, share
from rich.console import Console
from rich.table import Table
from short_drives import NAMED, at_rate, drives, injected, planned, truth

BENCH, ROBOT = "car draws", "mushr"
RATES = (20, 40)  # Hz
KINDS: tuple[Kind, ...] = ("simulator", "first principles")


@dataclass(frozen=True)
class Drawn:
    """A :class:`~sym2real.experiments.study.sweep.Job`: one draw at one rate, held against both bases."""

    rate: int
    bases: tuple[Base, ...]
    seed: int

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.seed}_{self.rate}"

    @property
    def asked(self) -> Record:
        """What the answer depends on."""
        return {"seed": self.seed, "rate": self.rate, "bases": [base.kind for base in self.bases]}

    def run(self, tell: Callable[[str], None]) -> Record:
        """The truth, and an answer by base."""
        robot = at_rate(self.rate)
        tell("planning")
        effects = truth(planned(robot, self.seed), self.seed)
        data, answers = drives(robot, self.seed, injected(robot, effects)), {}
        for base in self.bases:
            tell(f"diagnosing, {base.kind}")
            answers[base.kind] = diagnosed(base.equations, data)
        return {"truth": effects, "answers": answers}


def figures(records: Sequence[Record]) -> list[Figure]:
    """All four named, and each, by rate and base."""
    found: list[Figure] = []
    for rate in RATES:
        for kind in KINDS:
            own = [one["answers"][kind] for one in records if one["asked"]["rate"] == rate]
            title = f"{rate} Hz, base from {kind}" if kind == "simulator" else f"{rate} Hz, {kind}"
            found += share(f"{title}: all named", (all_named(one, NAMED) for one in own), ">= 0.90")
            for key in NAMED:
                found += share(f"{title}: {key} named", (named(one, key) for one in own))
    return found


def print_answers(records: Sequence[Record], console: Console) -> None:
    """Truth and findings of every draw."""
    table = Table(title="what was found", title_justify="left")
    for heading in ("draw", "truth", "verdict", "found"):
        table.add_column(heading, overflow="fold")
    for record in records:
        asked = record["asked"]
        true = ", ".join(f"{key} {next(iter(values.values())):.3g}" for key, values in record["truth"].items())
        for kind, answer in record["answers"].items():
            draw = f"#{asked['seed']} {asked['rate']} Hz, {kind}"
            table.add_row(draw, true, answer["verdict"], ", ".join(names(answer)))
    console.print(table)


def main(settings: Settings) -> None:
    """Plan, drive, diagnose, print, write."""
    seeds, place = settings.seeds_of(BENCH), settings.place(BENCH)
    bases = {rate: tuple(base_of(ROBOT, kind, place, 1.0 / rate) for kind in KINDS) for rate in RATES}
    jobs = [Drawn(rate, bases[rate], seed) for seed in seeds for rate in RATES]
    records = settings.answers(BENCH, jobs)
    print_answers(records, Console(stderr=True))
    report(BENCH, figures(records), seeds, settings.json)


if __name__ == "__main__":
    main(tyro.cli(Settings, description=__doc__))
