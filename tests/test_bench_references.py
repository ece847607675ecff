"""Kept references are taken where they would come out the same, and nowhere else."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from adaptation_references import keep, take_known

from sym2real.experiments.study.case import load_suite
from sym2real.experiments.study.effort import QUICK
from sym2real.experiments.study.judged import Reference
from sym2real.experiments.study.sweep import answer_file

SMALL = replace(QUICK, samples={"crazyflie": 4, "mushr": 4}, rows=4, evaluations=1)


def test_a_record_is_taken_while_the_reference_does_the_same(tmp_path: Path) -> None:
    kept, (light, heavy, *_) = tmp_path / "kept.json", load_suite("sim2sim").cases
    job = Reference(light, SMALL)
    record = {**job.run(lambda _: None), "asked": job.asked, "seconds": 1.0}
    keep([job], {job.name: record}, kept)
    take_known([job], tmp_path / "same", kept)
    assert json.loads(answer_file(tmp_path / "same", job.name).read_text()) == json.loads(json.dumps(record))
    changed = [
        Reference(light, replace(SMALL, samples={"crazyflie": 8})),
        Reference(replace(heavy, name=light.name), SMALL),
    ]
    for number, other in enumerate(changed):
        take_known([other], tmp_path / str(number), kept)
        assert not answer_file(tmp_path / str(number), job.name).exists()
