"""Whether a diagnosis says the same of measured logs when less of them, or another view of them, is given.

The logs of a set are diagnosed together, with every base of ``real_logs.py``: as they are, in a world that is turned
and moved, in another order, recorded later, the first and the second half of each, and without each of them. Held
against the answer on all of the logs: whether what that found is named again, by itself or by what physics takes for
it, and whether values lie in each other's intervals. Less data may leave an effect without a test; another effect in
its place is what should not be.

    python tools/bench/measured_invariance.py --sets mushr_steering_offset
    python tools/bench/measured_invariance.py --json build/measured_invariance.json
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import tyro
from answers import Record, answer_of, named, refusal, stands_for, within_both
from figures import Figure, report
from log_changes import CHANGES, Change, drawn_turn
from real_logs import DATA, bases
from repeated import Asked, Run, Settings, print_table, share

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.errors import Sym2RealError
from sym2real.experiments.study.sweep import Tell
from sym2real.logs import read_logs

BENCH, WHOLE, TURNED = "measured invariance", "as they are", "turned"
SETS = ("crazyflie_battery_drag", "crazyflie_two_pennies", "mushr_steering_offset")


@dataclass(frozen=True)
class Options:
    """Diagnose the measured logs in parts and in disguises.

    Args:
        data: folder with the sets.
        sets: those of them in which all logs are of one robot under one condition.
    """

    run: Run = field(default_factory=Settings)
    data: Path = DATA
    sets: tuple[str, ...] = SETS


def half(number: int) -> Change:
    """The first (0) or the second (1) half of every log."""
    return lambda data, _: Dataset(log.rows(number * len(log) // 2, (number + 1) * len(log) // 2) for log in data)


def without(left_out: int) -> Change:
    """All logs but one."""
    return lambda data, _: Dataset(log for number, log in enumerate(data) if number != left_out)


def changes(logs: Sequence[Path]) -> dict[str, Change]:
    """Name → what is done to the logs."""
    parts = {"first halves": half(0), "second halves": half(1)}
    parts |= {f"without {path.stem}": without(number) for number, path in enumerate(logs)}
    return {WHOLE: lambda data, _: data, **{name: CHANGES[name] for name in (TURNED, "later", "shuffled")}, **parts}


def part(folder: Path, base: str, change: str, seed: int) -> Asked:
    """A set against a base, changed."""
    asked = {"set": folder.name, "base": base, "change": change, "seed": seed}
    return Asked(f"{folder.name} {base} {change} {seed}", asked, partial(answer, folder, base, change, seed))


def answer(folder: Path, base: str, change: str, seed: int, tell: Tell) -> Record:
    """The answer, with the angle by which the worlds were turned."""
    logs = sorted(folder.glob("*.csv"))
    _, equations, plant = next(of for of in bases(folder.name, logs) if of[0] == base)
    data = read_logs(logs, spec=folder.name, layouts=equations.layouts, dt=equations.dt)
    changed = changes(logs)[change](data, np.random.default_rng(seed))
    angle = drawn_turn(np.random.default_rng(seed)).angle if change == TURNED else 0.0
    try:
        return {"angle": angle, **answer_of(diagnose(equations, changed, plant, on_progress=tell))}
    except Sym2RealError as error:
        return {"angle": angle, **refusal(error)}


def parts(options: Options) -> Iterator[Asked]:
    """Every set with every base in every disguise, one draw a seed."""
    for name in options.sets:
        logs = sorted((options.data / name).glob("*.csv"))
        for base, *_ in bases(name, logs):
            for seed in options.run.seeds_of(BENCH):
                yield from (part(options.data / name, base, change, seed) for change in changes(logs))


def figures(records: Sequence[Record], title: str) -> list[Figure]:
    """Of a set and a base: what of the whole logs' answer is found again in each disguise; prints that too."""
    whole = next(record for record in records if record["asked"]["change"] == WHOLE)
    wanted = [finding["effect"] for finding in whole["findings"]]
    again, held, new, rows = list[bool](), list[bool](), list[bool](), list[Sequence[str]]()
    for record in (record for record in records if record is not whole):
        missed = [key for key in wanted if not named(record, key)]
        beside = [f["effect"] for f in record["findings"] if not any(stands_for(f, key) for key in wanted)]
        rows.append((record["asked"]["change"], record["verdict"], ", ".join(missed), ", ".join(beside)))
        again += [key not in missed for key in wanted]
        new.append(not beside)
        held += within_both(whole, record, record["angle"])
    print_table(f"{title}: {', '.join(wanted)}", ("disguise", "verdict", "missed", "beside"), rows)
    found = share(f"{title}: effects named again", again, ">= 0.95")
    found += share(f"{title}: disguises with no other effect", new)
    return found + share(f"{title}: values within both intervals", held, ">= 0.90")


def main(options: Options) -> None:
    """Diagnose, print, write."""
    own: dict[str, list[Record]] = {}
    for record in options.run.answers(BENCH, list(parts(options))):
        own.setdefault(f"{record['asked']['set']}, {record['asked']['base']}", []).append(record)
    rows = [row for title, records in own.items() for row in figures(records, title)]
    report(BENCH, rows, options.run.seeds_of(BENCH), options.run.json)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
