"""What MPPI with the target's own MuJoCo reaches on the study's cases, kept with the repository: a case takes minutes.

A record is taken only where the reference still does the same: the case and the effort are equal, and so are the first
commands that it sends, which follow from target, cost, samples, noise and MuJoCo alike. Whatever else is run anew.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sym2real.experiments.study.judged import FIRST_SEED, Reference, planning_with_mujoco
from sym2real.experiments.study.sweep import Job, Record, answer_file
from sym2real.files import read_object, write_text
from sym2real.plants import run_episode

KEPT = Path(__file__).with_name("adaptation_references.json")
PROBED, DIGITS = 3, 6  # commands of the first episode, and their decimals: sums differ between processors


def key_of(job: Reference) -> dict[str, Any]:
    """What a reference depends on, as JSON holds it."""
    robot, task, plant = job.case.of_robot, job.case.of_task(), job.case.plant(FIRST_SEED)
    controller = planning_with_mujoco(job.effort)(plant, robot, task, FIRST_SEED)
    log = run_episode(plant, controller, task, seed=FIRST_SEED, steps=PROBED)
    key = {**job.asked, "commands": log.action.round(DIGITS).tolist()}
    return json.loads(json.dumps(key))


def take_known(jobs: Sequence[Job], folder: Path, kept: Path = KEPT) -> None:
    """Put the records that still hold into a sweep's folder, where it has none of its own."""
    known = read_object(kept, "records of references") if kept.exists() else {}
    for job in (one for one in jobs if isinstance(one, Reference) and one.name in known):
        file, there = answer_file(folder, job.name), known[job.name]
        if not file.exists() and there["key"] == key_of(job):
            write_text(file, json.dumps(there["record"], indent=1))


def keep(jobs: Sequence[Job], answers: Mapping[str, Record], kept: Path = KEPT) -> None:
    """Write the records of references beside this file; those of other cases stay."""
    known = read_object(kept, "records of references") if kept.exists() else {}
    new = {
        job.name: {"key": key_of(job), "record": answers[job.name]}
        for job in jobs
        if isinstance(job, Reference)
        and job.name in answers
        and known.get(job.name, {}).get("record") != answers[job.name]
    }
    if new:
        write_text(kept, json.dumps({**known, **new}, indent=1, sort_keys=True) + "\n")
