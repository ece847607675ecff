"""Whether one number wins over several that together do the same: a weak rotor, a force that swings, a slope, grip.

Every effect is twice as large as ``plan`` says is found, and matters, in the standard set's runs with every base that
can be given it (a bicycle without mass has no force). Bases are those of an analyst with commands of thrust and body
rates, or of steering and speed; what a diagnosis of the healthy robot's runs finds is added to first principles.

    python tools/bench/fewer_numbers.py --cases 1
    python tools/bench/fewer_numbers.py --cases 20 --sealed --json build/fewer_numbers.json
"""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import tyro
from answers import Record, first, stands_for
from bases import HEALTHY_SEED, Base, Kind, as_read, base_of, calibrated, diagnosed
from figures import Figure, report
from repeated import Asked, Settings, print_table, share
from standard_set import Case, simulate_case

from sym2real.diagnosis import Visible, plan
from sym2real.experiments.study.sweep import Tell
from sym2real.files import write_text
from sym2real.robots import ROBOTS

BENCH, LARGER = "fewer numbers", 2.0
EFFECTS = {"crazyflie": ("rotor_loss", "periodic_force"), "mushr": ("periodic_force", "slope", "tyre_friction")}
KINDS: tuple[Kind, ...] = ("simulator", "logs", "first principles")
# What plan speaks of → parameter, and the part of the effect's own size that this is.
SEEN = {
    "rotor_loss": ("rotor_loss 1", "value"),
    "periodic_force": ("periodic_force", "fx"),
    "slope": ("wind", "fx"),
    "tyre_friction": ("tyre_friction", "value"),
}
SWING = (3.0, 8.0)  # rad/s
LEAST_GRIP = 0.3


def announced(robot: str, base: Base, place: Path) -> dict[str, float]:
    """Size from which on every effect of a robot is found and matters, of a grip the smaller coefficient.

    Without the effects that the base cannot be given, or that ``plan`` promises at no size.
    """
    kept = place / f"announced_{robot}_{base.kind.replace(' ', '_')}.json"
    if not kept.exists():
        runs = as_read(base.equations, simulate_case(Case(robot, seed=HEALTHY_SEED)))
        rows = {(row.effect, row.parameter): row for row in plan(base.equations, runs).visible}
        shown = {key: rows[SEEN[key]] for key in EFFECTS[robot] if SEEN[key] in rows}
        write_text(kept, json.dumps({key: size for key, row in shown.items() if (size := _size(row)) is not None}))
    return json.loads(kept.read_text())


def _size(row: Visible) -> float | None:
    if row.smallest is None or row.matters is None:
        return None
    return (min if row.effect == "tyre_friction" else max)(row.smallest, row.matters)


def large(key: str, sizes: Sequence[float], mass: float) -> float:
    """Twice the least that every base which has it announces: N, m/s², a part of the thrust, a friction coefficient."""
    if key == "tyre_friction":
        return max(1.0 - LARGER * (1.0 - min(sizes)), LEAST_GRIP)
    return LARGER * max(sizes) / (mass if key == "slope" else 1.0)


def drawn(key: str, size: float, seed: int) -> dict[str, float]:
    """Parameters of that size; rotor, direction and frequency by seed."""
    rng = np.random.default_rng([seed, len(key)])
    direction = rng.uniform(-np.pi, np.pi)
    along = size * np.cos(direction), size * np.sin(direction)
    if key == "rotor_loss":
        return {"rotor": float(rng.integers(1, 5)), "value": size}
    if key == "periodic_force":
        return {"fx": float(along[0]), "fy": float(along[1]), "omega": float(rng.uniform(*SWING))}
    if key == "slope":
        return {"gx": float(along[0]), "gy": float(along[1])}
    return {"value": size}


def one_effect(case: Case, bases: tuple[Base, ...]) -> Asked:
    """One effect, held against every base."""
    asked = {"case": case.name, "bases": [base.kind for base in bases]}
    return Asked(f"{case.robot} {case.keys[0]} {case.seed}", asked, partial(answer, case, bases))


def answer(case: Case, bases: tuple[Base, ...], tell: Tell) -> Record:
    """An answer by base."""
    data, answers = simulate_case(case), {}
    for base in bases:
        tell(base.kind)
        answers[base.kind] = diagnosed(base.equations, data)
    return {"robot": case.robot, "truth": case.keys[0], "answers": answers}


def named_first(record: Record, kind: str) -> bool:
    """Whether the first finding against a base stands for the truth."""
    findings = record["answers"][kind]["findings"]
    return bool(findings) and stands_for(findings[0], record["truth"])


def figures(records: Sequence[Record]) -> list[Figure]:
    """Named first: of all, and by robot, effect and base."""
    every = [named_first(one, kind) for one in records for kind in one["answers"]]
    found = share("named first", every, ">= 0.95")
    for robot, keys in EFFECTS.items():
        for key in keys:
            own = [one for one in records if (one["robot"], one["truth"]) == (robot, key)]
            for kind in KINDS:
                right = [named_first(one, kind) for one in own if kind in one["answers"]]
                found += share(f"{robot}, {key}, {kind}", right) if right else []
    return found


def main(settings: Settings) -> None:
    """Plan, simulate, diagnose, print, write."""
    seeds, place, jobs = settings.seeds_of(BENCH), settings.place(BENCH), list[Asked]()
    for robot, keys in EFFECTS.items():
        made = (base_of(robot, kind, place) for kind in KINDS)
        bases = [calibrated(base) if base.kind == "first principles" else base for base in made]
        promised = [announced(robot, base, place) for base in bases]
        for key in keys:
            asked = tuple(base for base, sizes in zip(bases, promised, strict=True) if key in sizes)
            size = large(key, [sizes[key] for sizes in promised if key in sizes], ROBOTS[robot].mass)
            jobs += [one_effect(Case(robot, ((key, drawn(key, size, seed)),), seed, True), asked) for seed in seeds]
    records = settings.answers(BENCH, jobs)
    said = ((one["asked"]["case"], kind, first(found)) for one in records for kind, found in one["answers"].items())
    print_table("first finding", ("case", "base", "found"), said)
    report(BENCH, figures(records), seeds, settings.json)


if __name__ == "__main__":
    main(tyro.cli(Settings, description=__doc__))
