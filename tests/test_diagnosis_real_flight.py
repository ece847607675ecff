"""The real flight in the repository: its body drag must be named, and the error must fall."""

from __future__ import annotations

from itertools import pairwise

import pytest

from sym2real.data import example_flight
from sym2real.diagnosis import Diagnosis, diagnose, try_effect
from sym2real.experiments.thrust_of_log import thrust_of_log
from sym2real.logs import load_spec, read_log
from sym2real.robots import Motors, quadrotor
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory

SPEC = "crazyflie_battery_drag"


def flight(dt: float = 0.02) -> tuple[Equations, Trajectory]:
    """Equations of its motors, and the flight, with so many seconds from row to row."""
    motors = Motors(thrust=thrust_of_log(example_flight(), load_spec(SPEC)).per_mass)
    equations = quadrotor(None, interface="motors", attitude="measured", motors=motors, dt=dt)
    return equations, read_log(example_flight(), spec=SPEC, layouts=equations.layouts, dt=dt)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return diagnose(*flight())


def test_half_the_rows_show_the_same_drag() -> None:
    """An attitude that is held from row to row is late by half a row, and pushes against the motion."""
    fits = [try_effect(model, "linear_drag", log) for model, log in (flight(0.02), flight(0.04))]
    every, half = (fit.finding.values for fit in fits)
    for axis in ("cx", "cy"):
        assert half[axis] == pytest.approx(every[axis], rel=0.1)


def test_drag_of_a_real_flight_is_named_from_motor_level_equations(found: Diagnosis) -> None:
    assert found.verdict == "EFFECT"
    assert {"linear_drag", "quadratic_drag"} & {finding.effect for finding in found.findings}
    first, last = (found.ladder[place].horizons[0.8]["position"].value for place in (0, -1))
    assert last < 0.5 * first


def test_every_effect_that_is_announced_lowers_the_held_out_error(found: Diagnosis) -> None:
    """A finding that removes nothing, or whose value is as good as zero, moves no rung beyond its interval."""
    errors = [rung.horizons[0.8]["position"] for rung in found.ladder]
    assert all(after.value < before.low for before, after in pairwise(errors))
