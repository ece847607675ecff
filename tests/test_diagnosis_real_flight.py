"""The real flight in the repository: its body drag must be named, and the error must fall."""

from __future__ import annotations

from sym2real.data import example_flight
from sym2real.diagnosis import diagnose
from sym2real.experiments.real_flight import motor_level_equations
from sym2real.logs import read_log


def test_drag_of_a_real_flight_is_named_from_motor_level_equations() -> None:
    spec = "crazyflie_battery_drag"
    equations = motor_level_equations(example_flight(), spec)
    log = read_log(example_flight(), spec=spec, layouts=equations.layouts, dt=equations.dt)
    found = diagnose(equations, log)
    assert found.verdict == "EFFECT"
    assert {"linear_drag", "quadratic_drag"} & {finding.effect for finding in found.findings}
    first, last = (found.ladder[place].horizons[0.8]["position"].value for place in (0, -1))
    assert last < 0.5 * first
