"""An arm that hits the end stops of its description, by MuJoCo's own limits, which first-principles equations lack."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import two_links

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare, diagnose
from sym2real.diagnosis.data.segments import cut
from sym2real.diagnosis.faults.sanity import check
from sym2real.robots import Robot
from sym2real.robots.left_out import with_stops_marked
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import AT_A_STOP

STOP = 0.8  # rad
BEFORE, _, AFTER = two_links.MJCF.partition('<joint name="q2" axis="0 1 0" range="-2.5 2.5"')
MJCF = f'{BEFORE}<joint name="q2" axis="0 1 0" range="{-STOP} {STOP}"{AFTER}'
LINKS = Robot.from_mjcf(MJCF, name="links", dt=two_links.STEP)


@cache
def logs(damping: float = 0.0) -> Dataset:
    rows = [two_links.swings(damping, seconds=10.0, seed=seed, mjcf=MJCF) for seed in range(5)]
    return Dataset(
        Trajectory.from_arrays(log[:, 1:5], log[:, 5:7], LINKS.layouts, time=log[:, 0], name=f"log_{number}")
        for number, log in enumerate(rows)
    )


def test_pieces_at_an_end_stop_are_in_no_fit() -> None:
    checked = check(LINKS.nominal(), logs()).data
    met = [log.extra.get(AT_A_STOP, np.zeros(len(log))) for log in checked]
    assert sum(own.any() for own in met) == 2
    for log, own in zip(checked, met, strict=True):
        assert np.abs(log.column("q2")[own == 0]).max() < STOP
    segments = cut(checked)
    for number, first in zip(segments.log, segments.row, strict=True):
        assert not met[number][first : first + segments.length].any()
    assert len(segments) < len(cut(logs()))


def test_an_end_that_a_joint_goes_beyond_is_none() -> None:
    """The ends of many files are rough."""
    beyond = Dataset(log.with_columns({"q2": 1.3 * log.column("q2")}) for log in logs())
    assert not any(AT_A_STOP in log.extra for log in with_stops_marked(LINKS.nominal(), beyond))


def test_a_log_that_is_always_at_a_stop_is_judged_as_it_is() -> None:
    always = Dataset(log.with_columns({"q2": np.full(len(log), STOP)}) for log in logs())
    assert len(cut(check(LINKS.nominal(), always).data)) == len(cut(always))


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_what_the_equations_lack_at_a_stop_is_taken_for_no_effect(damping: float) -> None:
    found = diagnose(LINKS.nominal(), logs(damping))
    assert any("end stops of q2; pieces with them are left out" in note for note in found.notes)
    if damping:
        assert [finding.effect for finding in found.findings] == ["joint_damping:q1"], found.summary
        assert found.findings[0].values["value"] == pytest.approx(damping, rel=0.05)
    else:
        assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())


def test_a_comparison_leaves_nothing_out_and_says_so() -> None:
    """How far off a model is at a stop is what a user asks there."""
    compared = compare(LINKS.nominal(), logs())
    assert compared.at(0.5).errors["joint angle"].value > 0.05
    assert any(note.endswith("end stops of q2") for note in compared.notes)
