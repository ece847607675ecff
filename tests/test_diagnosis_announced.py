"""What is announced: no gain that another channel pays for, no share beyond the whole, no value at its bound."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from noisy_flights import flights_with

from sym2real.diagnosis import Gate, diagnose
from sym2real.diagnosis.data.windows import finite_errors
from sym2real.diagnosis.errors.rungs import SHORTEST_BLOCK, Rung, RungError, error_of
from sym2real.diagnosis.score.finding import shares_of
from sym2real.diagnosis.search.needed import largest_rise
from sym2real.effects import applicable
from sym2real.layout import Layout
from sym2real.robots import CRAZYFLIE


def stage(name: str, **errors: float) -> Rung:
    return Rung(name, {0.8: {key: RungError(value, value, value, value, "") for key, value in errors.items()}})


def test_a_position_error_that_doubles_is_not_made_up_for_by_attitude() -> None:
    assert not Gate(stage("base", position=1.0, attitude=1.0), stage("+ lag", position=2.0, attitude=0.5)).passed


@pytest.mark.parametrize(
    ("factor", "spread", "needed"),
    [(1.25, 0.0, True), (1.05, 0.0, False), (1.1, 0.6, False)],
    ids=["everywhere", "a little everywhere", "here and there"],
)
def test_an_effect_is_needed_where_errors_rise_by_a_tenth_in_all_logs_alike(
    factor: float, spread: float, needed: bool
) -> None:
    """Five short drives that are hard to predict here and easy there: an error by itself is known to a half."""
    rng = np.random.default_rng(0)
    log, block = np.repeat(np.arange(5), 40), np.repeat(np.arange(20), 10)
    errors = np.exp(rng.normal(0.0, 0.8, 20))[block]
    worse = errors * factor * np.exp(rng.normal(0.0, spread, 20))[block]
    whole, without = (Rung("", {0.8: {"position": error_of(values, log, "m")}}) for values in (errors, worse))
    assert without.horizons[0.8]["position"].low < whole.horizons[0.8]["position"].value
    assert (largest_rise(whole, without) > 1.0) is needed


@pytest.mark.parametrize("ahead", [8, 20, 50])
def test_an_interval_holds_the_error_of_windows_that_overlap(ahead: int) -> None:
    """Eight logs of 20 s, a window every 0.1 s, each error the sum of what comes in it: its size is known."""
    rng, log, held = np.random.default_rng(0), np.repeat(np.arange(8), 200), 0
    for _ in range(100):
        walks = rng.standard_normal((8, 200 + ahead, 2)).cumsum(1)
        errors = np.linalg.norm(walks[:, ahead:] - walks[:, :200], axis=-1).ravel()
        interval = error_of(errors, log, "m", max(SHORTEST_BLOCK, ahead))
        held += interval.low <= (2 * ahead) ** 0.5 <= interval.high
    assert held >= 80  # of the 95 that it promises: few blocks, from which an interval is drawn


def test_a_prediction_that_is_no_number_is_the_worst() -> None:
    layout, windows = Layout.of(["x"]), torch.zeros(30, 1, dtype=torch.float64)
    lost = windows.clone()
    lost[::20], lost[5::10] = float("nan"), float("inf")
    log = np.repeat(np.arange(3), 10)
    stages = [
        Rung("", {0.8: {name: error_of(values, log, "m") for name, values in errors.items()}})
        for errors in (finite_errors(layout, windows + 0.1, windows), finite_errors(layout, lost, windows))
    ]
    assert largest_rise(*stages) > 1.0
    assert Gate(*stages).worse


def test_no_finding_removes_more_than_there_is() -> None:
    shares = shares_of([100.0, 164.0, 20.0], 20.0)
    assert sum(shares) == pytest.approx(1.0)


@pytest.mark.slow
def test_a_value_at_its_bound_is_no_finding() -> None:
    """A board tilted by 0.16 rad, where 0.1 is the most that is likely, and nothing else that could stand for it."""
    base, data = CRAZYFLIE.nominal(), flights_with("mounting_tilt", {"roll": 0.16})
    found = diagnose(base, data, exclude=[other.key for other in applicable(base) if other.key != "mounting_tilt"])
    assert found.tried == 1
    assert (found.verdict, found.findings) == ("UNEXPLAINED", ())
