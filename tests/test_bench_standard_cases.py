"""Cases of the standard set: valid, distinct, and as many as there are to be."""

from __future__ import annotations

import pytest
from standard_cases import standard_cases

from sym2real.effects import effect
from sym2real.errors import UnknownNameError
from sym2real.robots import ROBOTS


@pytest.mark.parametrize("robot", ["crazyflie", "mushr"])
def test_cases_are_valid_distinct_and_complete(robot: str) -> None:
    quick, full = standard_cases(robot, quick=True), standard_cases(robot)
    assert len({case.seed for case in full}) == len(full)
    assert len({case.name for case in full}) == len(full)
    assert sum(not case.effects for case in full) == 300
    assert sum(not case.effects for case in quick) == 20
    for case in quick:
        for key, values in case.effects:
            effect(key, ROBOTS[robot]).inject(**values)


def test_a_robot_without_a_standard_set_is_named() -> None:
    with pytest.raises(UnknownNameError, match="crazyflie"):
        standard_cases("crazyfly")
