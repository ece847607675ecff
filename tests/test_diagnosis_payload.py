"""A load at an arm, welded to the robot in the simulator, is fitted as one: mass, centre of mass and inertia."""

from __future__ import annotations

import pytest
from noisy_flights import flights_with

from sym2real.diagnosis import diagnose, try_effect
from sym2real.robots import CRAZYFLIE

LOAD = {"mass": 0.004, "rx": 0.025, "ry": -0.025}


@pytest.mark.slow
def test_the_place_of_a_load_is_found() -> None:
    tested = try_effect(CRAZYFLIE.nominal(), "payload", flights_with("payload", LOAD, count=6))
    assert tested.supported, tested.summary
    (finding,) = tested.findings
    for name, value in LOAD.items():
        assert finding.parameters[name].value == pytest.approx(value, rel=0.05)


@pytest.mark.slow
def test_a_load_is_named_where_something_is_left_beside_what_stands_for_it() -> None:
    load = {"mass": 0.006, "rx": 0.03, "ry": 0.0}
    others = ("sensor_*", "*lag*", "delay*", "*limit*", "dead_*", "*drag*", "periodic*", "flapping*")
    found = diagnose(CRAZYFLIE.nominal(), flights_with("payload", load, count=6), exclude=others)
    assert [finding.effect for finding in found.findings] == ["payload"]
    assert found.findings[0].values["mass"] == pytest.approx(load["mass"], rel=0.05)
    assert found.findings[0].values["rx"] == pytest.approx(load["rx"], rel=0.05)
    reasons = {entry.effect: entry.reason for entry in found.not_tried}
    assert all(reasons[key].startswith("another effect") for key in ("added_mass", "com_offset"))
