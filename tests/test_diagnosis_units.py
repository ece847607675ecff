"""Columns in another unit and quaternions in another order are named and undone; what robots do themselves is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights, flights_with

from sym2real.data import example_flight
from sym2real.diagnosis import compare, diagnose
from sym2real.diagnosis.conventions import breaches
from sym2real.diagnosis.foreign_units import ForeignUnit
from sym2real.diagnosis.sanity import check
from sym2real.experiments.real_flight import motor_level_equations
from sym2real.experiments.standard_set import Case, simulate_case
from sym2real.logs import read_log
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.trajectory import Dataset

DEGREES = 180.0 / np.pi
Factors = dict[str, float]


def one_flight() -> Dataset:
    """A single circle of 4 s: what a user tries first."""
    return Dataset([flights()[1]])


def drives() -> Dataset:
    return simulate_case(Case("mushr", (), seed=4), 2, 150)


def times(data: Dataset, factors: Factors) -> Dataset:
    """Logs with columns of state and action in other units."""
    changed = []
    for log in data:
        state, action = log.state.copy(), log.action.copy()
        for column, factor in factors.items():
            values, layout = (state, log.layouts.state) if column in log.layouts.state else (action, log.layouts.action)
            values[:, layout.index(column)] *= factor
        changed.append(replace(log, state=state, action=action))
    return Dataset(changed)


def scalar_last(data: Dataset) -> Dataset:
    place = data.layouts.state.slice("attitude")
    states = [np.roll(log.state[:, place], -1, axis=-1) for log in data]
    return Dataset(
        replace(log, state=np.concatenate([log.state[:, : place.start], turned, log.state[:, place.stop :]], axis=1))
        for log, turned in zip(data, states, strict=True)
    )


def of(columns: str, factor: float) -> Factors:
    return dict.fromkeys(columns.split(), factor)


QUADROTOR = [
    (of("x y z", 1e3), ["x y z in mm instead of m"]),
    (of("x y z", 1e2) | of("vx vy vz", 1e2), ["x y z in cm instead of m", "vx vy vz in cm/s instead of m/s"]),
    (of("vx vy vz", 3.6), ["vx vy vz in km/h instead of m/s"]),
    (of("wx wy wz", DEGREES), ["wx wy wz in deg/s instead of rad/s"]),
    (of("wx_cmd wy_cmd wz_cmd", DEGREES), ["wx_cmd wy_cmd wz_cmd in deg/s instead of rad/s"]),
    (of("thrust", 1e3), ["thrust in mN instead of N"]),
    (of("thrust", 1.0 / CRAZYFLIE.mass), ["thrust in m/s^2 instead of N"]),
    (of("thrust", 1e3 / 9.80665), ["thrust in gf instead of N"]),
    (
        of("wx wy wz wx_cmd wy_cmd wz_cmd", DEGREES) | of("thrust x y z", 1e3),
        [
            "x y z in mm instead of m",
            "wx wy wz in deg/s instead of rad/s",
            "thrust in mN instead of N",
            "wx_cmd wy_cmd wz_cmd in deg/s instead of rad/s",
        ],
    ),
]
CAR = [
    (of("x y", 1e3), ["x y in mm instead of m"]),
    (of("vx vy", 1e2), ["vx vy in cm/s instead of m/s"]),
    (of("wz", DEGREES), ["wz in deg/s instead of rad/s"]),
    (of("steer", DEGREES), ["steer in deg instead of rad"]),
    (of("speed", 1e3), ["speed in mm/s instead of m/s"]),
]


@pytest.mark.parametrize(
    ("robot", "factors", "said"), [(CRAZYFLIE, *one) for one in QUADROTOR] + [(MUSHR, *one) for one in CAR]
)
def test_another_unit_is_named_and_undone(robot: object, factors: Factors, said: list[str]) -> None:
    data, model = (one_flight(), CRAZYFLIE.nominal()) if robot is CRAZYFLIE else (drives(), MUSHR.nominal())
    checked = check(model, times(data, factors))
    assert sorted(fault.name for fault in checked.faults) == sorted(said)
    assert all("unit = " in fault.fix for fault in checked.faults)
    for log, right in zip(checked.data, data, strict=True):
        np.testing.assert_allclose(log.state, right.state, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(log.action, right.action, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ({}, []),
        (of("wx", -DEGREES) | of("wy wz", DEGREES), ["wx wy wz in deg/s instead of rad/s", "sensor_sign:wx"]),
    ],
)
def test_the_scalar_last_is_named_beside_units_and_signs(factors: Factors, said: list[str]) -> None:
    data = one_flight()
    checked = check(CRAZYFLIE.nominal(), scalar_last(times(data, factors)))
    assert [fault.name for fault in checked.faults] == ["quaternions with the scalar last (x y z w)", *said]
    np.testing.assert_allclose(checked.data[0].state, data[0].state, rtol=1e-9, atol=1e-12)


def test_a_factor_of_no_unit_is_told_with_the_scale_that_undoes_it() -> None:
    data = one_flight()
    (found,), undone = breaches(times(data, {"thrust": 70_000.0}), CRAZYFLIE.nominal())
    assert isinstance(found, ForeignUnit)
    assert found.unit == ""
    assert found.factor == pytest.approx(70_000.0, rel=0.05)
    assert f"scale = {1.0 / found.factor:.4g}" in found.fix
    np.testing.assert_allclose(undone[0].action, data[0].action, rtol=0.05)


@pytest.mark.parametrize(("factor", "unit"), [(100.0, "%"), (65535.0, "uint16")])
def test_motors_in_percent_or_16_bits_are_named_on_a_measured_flight(factor: float, unit: str) -> None:
    flight, name = example_flight(), "crazyflie_battery_drag"
    model = motor_level_equations(flight, name)
    data = Dataset([read_log(flight, spec=name, layouts=model.layouts, dt=model.dt)])
    motors = "motor1 motor2 motor3 motor4"
    assert breaches(data, model)[0] == []
    (found,), undone = breaches(times(data, of(motors, factor)), model)
    assert isinstance(found, ForeignUnit)
    assert (" ".join(found.columns), found.unit) == (motors, unit)
    np.testing.assert_allclose(undone[0].action, data[0].action, rtol=1e-9)


EFFECTS = [
    ("gain:thrust", {"value": 0.6}),
    ("gain:wx_cmd", {"value": 0.4}),
    ("delay", {"value": 0.1}),
    ("added_mass", {"value": 0.015}),
    ("wind", {"fx": 0.08}),
]


@pytest.mark.parametrize(("key", "values"), EFFECTS)
def test_a_strong_effect_is_no_other_unit(key: str, values: Factors) -> None:
    assert breaches(flights_with(key, values, count=2), CRAZYFLIE.nominal())[0] == []


def test_sound_logs_of_both_robots_and_a_hover_alone_have_no_breach() -> None:
    assert breaches(flights(), CRAZYFLIE.nominal())[0] == []
    assert breaches(Dataset([flights()[0]]), CRAZYFLIE.nominal())[0] == []
    assert breaches(drives(), MUSHR.nominal())[0] == []


def test_compare_and_diagnose_say_it_and_nothing_else_is_missing() -> None:
    broken, model = times(flights(), of("wx wy wz", DEGREES)), CRAZYFLIE.nominal()
    lines = compare(model, broken).data.lines()
    assert [line for line in lines if "deg/s" in line] == [line for line in lines if "instead of" in line] != []
    found = diagnose(model, broken, exclude=("*:*",))
    assert found.verdict == "EFFECT"
    assert found.findings == ()
    assert found.summary.startswith("The data show wx wy wz in deg/s instead of rad/s")
