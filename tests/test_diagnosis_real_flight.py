"""The real flight in the repository: its body drag must be seen, by name or as what is left over."""

from __future__ import annotations

from sym2real.data import example_flight
from sym2real.diagnosis import diagnose
from sym2real.experiments.real_flight import motor_level_equations
from sym2real.logs import read_log


def test_drag_of_a_real_flight_is_seen_from_motor_level_equations() -> None:
    spec = "crazyflie_battery_drag"
    equations = motor_level_equations(example_flight(), spec)
    log = read_log(example_flight(), spec=spec, layouts=equations.layouts, dt=equations.dt)
    found = diagnose(equations, log)
    assert found.verdict in ("EFFECT", "UNEXPLAINED")
    named = any(finding.effect in ("linear_drag", "quadratic_drag") for finding in found.findings)
    left = found.leftover is not None and "velocity" in found.leftover.explained_by
    assert named or left
