"""What is announced: no gain that another channel pays for, no share beyond the whole, no value at its bound."""

from __future__ import annotations

import pytest
from noisy_flights import LEFT_OUT, flights_with

from sym2real.diagnosis import Gate, diagnose
from sym2real.diagnosis.errors.rungs import Stage, StageError
from sym2real.diagnosis.score.finding import shares_of
from sym2real.effects import effect
from sym2real.robots import CRAZYFLIE


def stage(name: str, **errors: float) -> Stage:
    return Stage(name, {0.8: {key: StageError(value, value, value, value, "") for key, value in errors.items()}})


def test_a_position_error_that_doubles_is_not_made_up_for_by_attitude() -> None:
    assert not Gate(stage("base", position=1.0, attitude=1.0), stage("+ lag", position=2.0, attitude=0.5)).passed


def test_no_finding_removes_more_than_there_is() -> None:
    shares = shares_of([100.0, 164.0, 20.0], 20.0)
    assert sum(shares) == pytest.approx(1.0)


def test_a_value_at_its_bound_is_no_finding() -> None:
    """Rotors that take 0.6 s, twice what the search allows for."""
    base, data = CRAZYFLIE.nominal(), flights_with("motor_lag", {"value": 0.6})
    found = diagnose(base, data, exclude=tuple(key for key in LEFT_OUT if key != "motor_lag"))
    at_bounds = [
        (one.effect, name)
        for one in found.findings
        for name, value in one.values.items()
        for known in effect(one.effect, base).parameters
        if known.name == name and not known.low < value < known.high
    ]
    assert not (found.verdict == "EFFECT" and at_bounds)
