"""Logs of a few rows, and logs in which nothing moves: refused by name, or left out beside others and noted."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights

from sym2real.dataset import Dataset
from sym2real.diagnosis import compare, data_report, diagnose, plan, try_effect
from sym2real.diagnosis.data.segments import cut, segment_length
from sym2real.diagnosis.errors.rungs import cut_notes
from sym2real.diagnosis.question import Question, check_data
from sym2real.errors import ShapeError
from sym2real.robots import CRAZYFLIE, MUSHR, Robot

BASE = CRAZYFLIE.nominal()


@pytest.mark.parametrize("rows", [1, 2, 10])
def test_a_log_of_a_few_rows_is_refused_by_name(rows: int) -> None:
    short = replace(flights()[0].rows(0, rows), name="short one")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for ask in (lambda: compare(BASE, short), lambda: diagnose(BASE, short), lambda: plan(BASE, short)):
            with pytest.raises(ShapeError, match=rf"{rows} rows? in short one"):
                ask()
        with pytest.raises(ShapeError, match="short one"):
            data_report(short)


def test_a_short_piece_beside_a_log_is_left_out_and_noted() -> None:
    """It has no noise level and no time step, and made those of all logs no number."""
    whole = flights()[0].rows(0, 120)
    pieces = Dataset([whole, replace(whole.rows(0, 1), name="piece"), replace(whole.rows(0, 3), name="other")])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compared, checked = compare(BASE, pieces), check_data(Question(BASE, pieces)).checked
    assert [log.name for log in checked.data] == [whole.name]
    for notes in (compared.notes, checked.notes):
        assert any("1 row in piece, 3 rows in other" in note for note in notes)
    alone = compare(BASE, whole)
    assert compared.free_run.errors["position"].value == pytest.approx(alone.free_run.errors["position"].value, 1e-12)


def test_a_log_too_short_for_a_segment_is_named() -> None:
    with pytest.raises(ShapeError, match="at least 46 moving rows, found 30 rows in hover"):
        cut(Dataset([replace(flights()[0].rows(0, 30), name="hover")]))


@pytest.mark.parametrize(("robot", "seconds"), [(CRAZYFLIE, 0.5), (MUSHR, 1.0)], ids=["quadrotor", "car"])
@pytest.mark.parametrize("rate", [50, 80, 200])
def test_a_segment_lasts_as_long_whatever_the_rate_of_its_log(robot: Robot, seconds: float, rate: int) -> None:
    """Of a car at 50 Hz, half a second said too little of what slows it."""
    assert segment_length(robot.layouts.state, 1.0 / rate) / rate == pytest.approx(seconds)


def test_a_frozen_log_is_said_to_be_frozen() -> None:
    log = flights()[0]
    frozen = replace(log, state=np.repeat(log.state[:1], len(log), axis=0), name="stood still")
    with pytest.raises(ShapeError, match="does not change from row to row in stood still"):
        cut(Dataset([frozen]))


def test_a_ladder_that_the_logs_cut_says_so() -> None:
    assert cut_notes((0.1, 0.5, 2.0), 100.0) == (
        "no held-out log is long enough for a horizon of 100 s: the ladder ends at 2 s",
    )
    assert cut_notes((0.1, 0.5, 2.0), 2.0) == cut_notes((0.1,), None) == ()
    for horizon in (0.001, 0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ShapeError, match="at least one time step"):
            diagnose(BASE, flights(), horizon=horizon)
        with pytest.raises(ShapeError, match="at least one time step"):
            try_effect(BASE, "wind", flights(), horizon=horizon)
