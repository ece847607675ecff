"""A force that swings is found with its frequency in flights whose paths swing too; where none does, none is found."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from noisy_flights import LEFT_OUT, flights_with
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate import swing
from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.estimate.swing import Swing, find_swing
from sym2real.diagnosis.estimate.weighing import whiten
from sym2real.diagnosis.predict.candidate import candidates, library_for
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.effects import effect
from sym2real.experiments.models import cached_base
from sym2real.robots import CRAZYFLIE, ROBOTS

OTHERS = (*LEFT_OUT, "rate_loop_gain", "mounting_tilt")
FORCE = {"fx": 0.012, "fy": 0.006, "omega": 7.0}


def found_in(data: Dataset, chance: float | None = None) -> Swing | None:
    library = library_for(CRAZYFLIE.nominal(), data, OTHERS)
    problem, tried = Problem(library, data), candidates(library, data)
    whitened = whiten(problem, tried)
    chance = SETTINGS.false_alarms_of_each(len(tried)) if chance is None else chance
    return find_swing(Problems.of(whitened.problem, whitened.whitening), whitened.values, chance)


@pytest.mark.parametrize("chance", [None, 0.2])
def test_no_swing_is_found_in_flights_on_periodic_paths(chance: float | None) -> None:
    """Frequencies share the chance, of which there are dozens."""
    assert found_in(flights_with("", {}, steps=400), chance) is None


def test_a_steady_wind_is_no_swing() -> None:
    assert found_in(flights_with("wind", {"fx": 0.02, "fy": 0.0}, steps=400)) is None


def test_a_swing_is_named_with_its_frequency_and_size() -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    found = diagnose(CRAZYFLIE.nominal(), data, exclude=OTHERS)
    assert [one.effect for one in found.findings] == ["periodic_force"]
    (one,) = found.findings
    for name, value in FORCE.items():
        assert one.values[name] == pytest.approx(value, rel=0.1 if name != "omega" else 0.01)
    assert one.parameters["omega"].low <= FORCE["omega"] <= one.parameters["omega"].high
    assert found.gate.passed


def test_the_angle_in_the_logs_is_the_one_that_the_force_had() -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    swing = found_in(data)
    assert swing is not None
    library = library_for(CRAZYFLIE.nominal(), data, OTHERS)
    values = library.null
    for slot, name in zip(library.indices("periodic_force"), ("fx", "fy"), strict=False):
        values[slot] = FORCE[name]
    told = CRAZYFLIE.nominal()
    true = effect("periodic_force", told).substitute(told, {**FORCE, "phase": swing.phases[0]})
    alone, first = library_for(true, Dataset([data[0]]), ("*",)), Dataset([data[0]])
    swung = Swing(FORCE["omega"], 0.0, swing.phases[:1]).in_data(first)
    expected = Problem(alone, first).residuals(alone.null[None])
    torch.testing.assert_close(Problem(library, swung).residuals(values[None]), expected, rtol=1e-6, atol=1e-9)
    assert np.allclose(np.cos(swing.phases), 1.0, atol=0.05)


def test_a_swing_that_moves_a_car_more_than_all_else_is_no_disturbance() -> None:
    """What swings makes disturbances look larger, and so a large one was hidden where half of it was found."""
    size = {"fx": -4.6, "fy": 1.8, "omega": 4.1}
    data = simulate_case(Case("mushr", (("periodic_force", size),), seed=6))
    first = diagnose(cached_base(ROBOTS["mushr"]), data).findings[0]
    assert first.effect == "periodic_force"
    assert first.values["omega"] == pytest.approx(size["omega"], rel=0.005)
    assert np.hypot(first.values["fx"], first.values["fy"]) == pytest.approx(np.hypot(size["fx"], size["fy"]), rel=0.1)


def test_frequencies_are_tried_alike_however_many_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    data = flights_with("periodic_force", FORCE, steps=400)
    found = []
    for count in (7, 10_000):
        monkeypatch.setattr(swing, "AT_A_TIME", count)
        found.append(found_in(data))
    assert found[0] is not None
    assert found[0] == found[1]
