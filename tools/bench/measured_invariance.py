"""Whether a diagnosis says the same of measured logs when less of them, or another view of them, is given.

The logs of a set are diagnosed together, with every base of ``real_logs.py``: as they are, in a world that is turned
and moved, in another order, recorded later, the first and the second half of each, and without each of them. Held
against the answer on all of the logs: whether what that found is named again, by itself or by what physics takes for
it, and whether values lie in each other's intervals. Less data may leave an effect without a test; another effect in
its place is what should not be.

    python tools/bench/measured_invariance.py --sets mushr_steering_offset
    python tools/bench/measured_invariance.py --json build/measured_invariance.json
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from answers import Record, answer_of, named, refusal, stands_for, within_both
from figures import Figure, report
from log_changes import CHANGES, Change, drawn_turn
from real_logs import BESIDE, bases
from repeated import Settings, share
from rich.console import Console
from rich.table import Table

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.errors import Sym2RealError
from sym2real.logs import read_logs

BENCH, WHOLE, TURNED = "measured invariance", "as they are", "turned"
SETS = ("crazyflie_battery_drag", "crazyflie_two_pennies", "mushr_steering_offset")


@dataclass(frozen=True)
class Options:
    """Diagnose the measured logs in parts and in disguises."""

    run: Annotated[Settings, tyro.conf.arg(name="")] = field(default_factory=Settings)
    data: Path = BESIDE
    """Folder with the sets."""
    sets: tuple[str, ...] = SETS
    """Those of them in which all logs are of one robot under one condition."""


def half(number: int) -> Change:
    """The first (0) or the second (1) half of every log."""

    def of(data: Dataset, _: np.random.Generator) -> Dataset:
        return Dataset(log.rows(number * len(log) // 2, (number + 1) * len(log) // 2) for log in data)

    return of


def without(left_out: int) -> Change:
    """All logs but one."""
    return lambda data, _: Dataset(log for number, log in enumerate(data) if number != left_out)


def changes(logs: Sequence[Path]) -> dict[str, Change]:
    """Name → what is done to the logs."""
    parts = {"first halves": half(0), "second halves": half(1)}
    parts |= {f"without {path.stem}": without(number) for number, path in enumerate(logs)}
    return {WHOLE: lambda data, _: data, **{name: CHANGES[name] for name in (TURNED, "later", "shuffled")}, **parts}


@dataclass(frozen=True)
class Part:
    """A :class:`~sym2real.experiments.study.sweep.Job`: a set against a base, changed."""

    folder: Path
    base: str
    change: str
    seed: int

    @property
    def name(self) -> str:
        """Of its file."""
        return "_".join((self.folder.name, self.base, self.change, str(self.seed))).replace(" ", "_")

    @property
    def asked(self) -> Record:
        """What the answer depends on."""
        return {"set": self.folder.name, "base": self.base, "change": self.change, "seed": self.seed}

    def run(self, tell: Callable[[str], None]) -> Record:
        """The answer, with the angle by which the worlds were turned."""
        logs = sorted(self.folder.glob("*.csv"))
        base = next(of for of in bases(self.folder.name, logs) if of[0] == self.base)
        data = read_logs(logs, spec=self.folder.name, layouts=base[1].layouts, dt=base[1].dt)
        changed = changes(logs)[self.change](data, np.random.default_rng(self.seed))
        angle = drawn_turn(np.random.default_rng(self.seed)).angle if self.change == TURNED else 0.0
        try:
            return {**self.asked, "angle": angle, **answer_of(diagnose(base[1], changed, base[2], on_progress=tell))}
        except Sym2RealError as error:
            return {**self.asked, "angle": angle, **refusal(error)}


def parts(options: Options) -> Iterator[Part]:
    """Every set with every base in every disguise, one draw a seed."""
    for name in options.sets:
        logs = sorted((options.data / name).glob("*.csv"))
        for base, *_ in bases(name, logs):
            for seed in options.run.seeds_of(BENCH):
                yield from (Part(options.data / name, base, change, seed) for change in changes(logs))


def figures_and_table(records: Sequence[Record], title: str) -> tuple[list[Figure], Table]:
    """Of a set and a base: what of the whole logs' answer is found again in each disguise."""
    whole = next(record for record in records if record["change"] == WHOLE)
    wanted = [finding["effect"] for finding in whole["findings"]]
    table = Table(
        "disguise", "verdict", "missed", "beside", title=f"{title}: {', '.join(wanted)}", title_justify="left"
    )
    again, held, new = list[bool](), list[bool](), list[bool]()
    for record in (record for record in records if record is not whole):
        missed = [key for key in wanted if not named(record, key)]
        beside = [f["effect"] for f in record["findings"] if not any(stands_for(f, key) for key in wanted)]
        table.add_row(record["change"], record["verdict"], ", ".join(missed), ", ".join(beside))
        again += [key not in missed for key in wanted]
        new.append(not beside)
        held += within_both(whole, record, record["angle"])
    found = share(f"{title}: effects named again", again, ">= 0.95")
    found += share(f"{title}: disguises with no other effect", new)
    return [*found, *share(f"{title}: values within both intervals", held, ">= 0.90")], table


def main(options: Options) -> None:
    """Diagnose, print, write."""
    console, rows = Console(stderr=True), list[Figure]()
    records = options.run.answers(BENCH, list(parts(options)))
    for title in dict.fromkeys(f"{record['set']}, {record['base']}" for record in records):
        own = [record for record in records if f"{record['set']}, {record['base']}" == title]
        figures, table = figures_and_table(own, title)
        console.print(table)
        rows += figures
    report(BENCH, rows, options.run.seeds_of(BENCH), options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
