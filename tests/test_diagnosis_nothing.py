"""A healthy robot: nothing is found, nothing is left over, and nothing goes wrong on the way to saying so."""

from __future__ import annotations

import pytest

from sym2real.diagnosis import diagnose
from sym2real.experiments.standard_set import Case, simulate_case
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_of_a_healthy_robot_nothing_is_missing(robot: Robot) -> None:
    """A car has no parameter that is free beside the findings: without any of them there is no unknown at all."""
    found = diagnose(robot.nominal(), simulate_case(Case(robot.name, seed=3), 4, 200), MujocoPlant(robot))
    assert found.verdict == "NOTHING_MISSING"
    assert found.findings == found.leftovers == found.faults == ()
