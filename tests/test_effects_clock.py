"""The time that equations see: from where a recording began, in however many logs it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis.question import Question, check_data
from sym2real.effects.inputs import DROPOUT, inputs_along, with_common_clock
from sym2real.experiments.flights import quadrotor_flights
from sym2real.layout import Layout
from sym2real.robots import ROBOTS
from sym2real.trajectory import Trajectory

CLOCK = Layout.of(["t"])


@pytest.fixture(scope="module")
def flight() -> Trajectory:
    """A recording whose stamps are those of a wall clock."""
    flown = quadrotor_flights(1, 3, steps=120)[0]
    return replace(flown, time=flown.time + 1_700_000_000.0)


def test_a_log_in_pieces_has_the_clock_of_the_whole_in_any_order(flight: Trajectory) -> None:
    whole = inputs_along(CLOCK, flight)
    bounds = ((70, 120), (0, 40), (50, 70))  # ten rows are missing, as after a dropout
    pieces = with_common_clock(Dataset(replace(flight.rows(*rows), name=str(rows)) for rows in bounds))
    for rows, piece in zip(bounds, pieces, strict=True):
        np.testing.assert_allclose(inputs_along(CLOCK, piece), whole[slice(*rows)], atol=1e-6)


def test_logs_that_do_not_go_on_keep_their_own_clocks(flight: Trajectory) -> None:
    later = replace(flight, time=flight.time + (flight.time[-1] - flight.time[0]) + 2 * DROPOUT, name="later")
    same = replace(flight, name="at the same time")
    for log in with_common_clock(Dataset([later, flight, same])):
        assert "t" not in log.extra
        assert float(inputs_along(CLOCK, log)[0, 0]) == 0.0


def test_logs_kept_aside_have_the_clock_of_what_they_go_on_from(flight: Trajectory) -> None:
    first, *rest = (replace(flight.rows(*rows), name=str(rows)) for rows in ((0, 50), (50, 90), (90, 120)))
    question = Question(ROBOTS["crazyflie"].nominal(), Dataset([first]), held_out=Dataset(rest))
    whole = inputs_along(CLOCK, flight)
    aside = check_data(question).aside
    assert aside is not None
    for log, begun in zip(aside.data, (50, 90), strict=True):
        np.testing.assert_allclose(inputs_along(CLOCK, log)[0], whole[begun], atol=1e-6)
