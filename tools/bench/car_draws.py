"""A car driven for 3 s at a time that has play, an offset, a delay, an arm and a speed map of its own, all at once.

Twenty drives a draw (short_drives.py), each effect twice as large as ``plan`` says can be seen, at 20 and at 40 Hz,
against a base from the plain simulator, which gets logs of 40 Hz resampled, and against first principles.

    python tools/bench/car_draws.py --cases 1
    python tools/bench/car_draws.py --cases 20 --sealed --json build/car_draws.json
"""

from collections.abc import Iterator, Sequence
from functools import partial

import tyro
from answers import Record, all_named, named, names
from bases import Base, Kind, base_of, diagnosed
from figures import Figure, report
from repeated import Asked, Settings, print_table, share
from short_drives import NAMED, drives, injected, planned, truth

from sym2real.experiments.study.sweep import Tell
from sym2real.robots import ROBOTS

BENCH, ROBOT = "car draws", "mushr"
RATES = (20, 40)  # Hz
KINDS: tuple[Kind, ...] = ("simulator", "first principles")


def draw(rate: int, bases: tuple[Base, ...], seed: int) -> Asked:
    """One draw at one rate, held against both bases."""
    asked = {"seed": seed, "rate": rate, "bases": [base.kind for base in bases]}
    return Asked(f"{seed} {rate}", asked, partial(answer, rate, bases, seed))


def answer(rate: int, bases: tuple[Base, ...], seed: int, tell: Tell) -> Record:
    """The truth, and an answer by base."""
    robot = ROBOTS[ROBOT].at_period(1.0 / rate)
    tell("planning")
    effects = truth(planned(robot, seed), seed)
    data, answers = drives(robot, seed, injected(robot, effects)), {}
    for base in bases:
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


def said(record: Record) -> Iterator[Sequence[str]]:
    """Truth and findings of a draw, by base."""
    asked = record["asked"]
    true = ", ".join(f"{key} {next(iter(values.values())):.3g}" for key, values in record["truth"].items())
    for kind, found in record["answers"].items():
        yield f"#{asked['seed']} {asked['rate']} Hz, {kind}", true, found["verdict"], ", ".join(names(found))


def main(settings: Settings) -> None:
    """Plan, drive, diagnose, print, write."""
    seeds, place = settings.seeds_of(BENCH), settings.place(BENCH)
    bases = {rate: tuple(base_of(ROBOT, kind, place, 1.0 / rate) for kind in KINDS) for rate in RATES}
    records = settings.answers(BENCH, [draw(rate, bases[rate], seed) for seed in seeds for rate in RATES])
    print_table("what was found", ("draw", "truth", "verdict", "found"), (row for one in records for row in said(one)))
    report(BENCH, figures(records), seeds, settings.json)


if __name__ == "__main__":
    main(tyro.cli(Settings, description=__doc__))
