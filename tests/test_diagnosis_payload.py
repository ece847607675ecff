"""A load at an arm, welded to the robot in the simulator, is fitted as one: mass, centre of mass and inertia."""

from __future__ import annotations

import pytest
from noisy_flights import flights_with

from sym2real.diagnosis import try_effect
from sym2real.robots import CRAZYFLIE

LOAD = {"mass": 0.004, "rx": 0.025, "ry": -0.025}


@pytest.mark.slow
def test_the_place_of_a_load_is_found() -> None:
    tested = try_effect(CRAZYFLIE.nominal(), "payload", flights_with("payload", LOAD, count=6))
    assert tested.supported, tested.summary
    (finding,) = tested.findings
    for name, value in LOAD.items():
        assert finding.parameters[name].value == pytest.approx(value, rel=0.05)
