"""The real flight in the repository: its body drag must be named, and the error must fall."""

from __future__ import annotations

from itertools import pairwise

import pytest

from sym2real.data import example_flight
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.experiments.thrust_of_log import thrust_of_log
from sym2real.logs import load_spec, read_log
from sym2real.robots import Motors, quadrotor


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    spec = "crazyflie_battery_drag"
    motors = Motors(thrust=thrust_of_log(example_flight(), load_spec(spec)).per_mass)
    equations = quadrotor(None, interface="motors", attitude="measured", motors=motors, dt=0.02)
    return diagnose(equations, read_log(example_flight(), spec=spec, layouts=equations.layouts, dt=equations.dt))


def test_drag_of_a_real_flight_is_named_from_motor_level_equations(found: Diagnosis) -> None:
    assert found.verdict == "EFFECT"
    assert {"linear_drag", "quadratic_drag"} & {finding.effect for finding in found.findings}
    first, last = (found.ladder[place].horizons[0.8]["position"].value for place in (0, -1))
    assert last < 0.5 * first


def test_every_effect_that_is_announced_lowers_the_held_out_error(found: Diagnosis) -> None:
    """A finding that removes nothing, or whose value is as good as zero, moves no rung beyond its interval."""
    errors = [rung.horizons[0.8]["position"] for rung in found.ladder]
    assert all(after.value < before.low for before, after in pairwise(errors))
