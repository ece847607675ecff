"""Motors in another order, or that turn the other way: seen in MuJoCo's flights of four motors and in real ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motor_flights import MIXER, equations, motor_flights, reordered

from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.motor_columns import order_of_motors, spin_text, turned_the_other_way
from sym2real.diagnosis.faults.sanity import check
from sym2real.logs import read_logs
from sym2real.logs.motor_order import ORDERS, Turning, motor_order
from sym2real.robots import Motors, quadrotor

SWAPPED = (1, 0, 2, 3)
PX4 = (0, 3, 1, 2)  # of motor1 to motor4, the place in PX4's order
OTHER_WAY = (1, -1, 1, -1)


@pytest.fixture(scope="module")
def lagging() -> Dataset:
    return motor_flights(lag=0.05)


@pytest.mark.slow
def test_every_other_order_is_named(lagging: Dataset) -> None:
    model = equations()
    assert order_of_motors(model, lagging) is None
    for order in ORDERS[1:]:
        found = order_of_motors(model, reordered(lagging, order))
        assert found is not None, order
        assert found.certain, order
        assert not found.reversed, order
        assert [order[column] for column in found.columns] == [0, 1, 2, 3]
        assert found.correlation > 0.7
        assert found.as_it_stands < 0.6


@pytest.mark.slow
@pytest.mark.parametrize(
    "hidden",
    [{}, {"com": (0.003, -0.002, 0.0)}, {"strength": (1.0, 0.9, 1.0, 1.0)}, {"dither": 0.0}],
    ids=["nothing", "centre of mass", "rotor loss", "no dither"],
)
def test_motors_in_order_are_no_fault_whatever_else_is_wrong(hidden: dict[str, object]) -> None:
    assert order_of_motors(equations(), motor_flights(**hidden)) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("rows", [-3, 3])
def test_a_log_with_its_motors_60_ms_off_keeps_its_order(lagging: Dataset, rows: int) -> None:
    # Beyond the shifts that are tried, and on top of rotors that lag.
    first, last = max(0, -rows), -max(0, rows) or None
    shifted = Dataset(
        replace(log.rows(first, len(log) - max(0, rows)), action=np.roll(log.action, -rows, axis=0)[first:last])
        for log in lagging
    )
    assert order_of_motors(equations(), shifted) is None
    found = order_of_motors(equations(), reordered(shifted, SWAPPED))
    assert found is not None
    assert found.columns == SWAPPED


def test_what_hover_cannot_tell_is_not_undone() -> None:
    data = motor_flights(names=("hover",), seconds=12.0, dither=0.0)
    assert order_of_motors(equations(), data) is None
    permuted = reordered(data, PX4)
    checked = check(equations(), permuted)
    (fault,) = checked.faults
    assert "the log does not tell which" in fault.evidence
    np.testing.assert_array_equal(checked.data[0].action, permuted[0].action)


def test_too_short_a_flight_says_nothing(lagging: Dataset) -> None:
    short = reordered(Dataset([lagging[1].rows(0, 250)]), SWAPPED)
    assert order_of_motors(equations(), short) is None


def test_two_short_bursts_far_apart_say_nothing() -> None:
    rng, time = np.random.default_rng(0), 0.002 * np.arange(10)
    time = np.concatenate([time, 2.0 + time])
    rates, caused = rng.standard_normal((20, 3)), rng.standard_normal((len(ORDERS), 20, 3))
    assert motor_order([Turning(time, rates, np.zeros((20, 0)), caused)]) is None


def test_an_order_that_fits_hardly_better_is_no_fault() -> None:
    rng, time = np.random.default_rng(0), 0.01 * np.arange(3000)
    caused = rng.standard_normal((len(ORDERS), len(time), 3))
    rates = np.concatenate([np.zeros((1, 3)), np.cumsum(0.01 * caused[1, :-1], axis=0)])
    found = motor_order([Turning(time, rates, np.zeros((len(time), 0)), caused)])
    assert found is not None
    assert found.columns == ORDERS[1]
    alike = np.concatenate([caused[1:2] + 0.1 * caused[:1], caused[1:]])
    assert motor_order([Turning(time, rates, np.zeros((len(time), 0)), alike)]) is None


def test_an_order_is_said_and_undone(lagging: Dataset) -> None:
    checked = check(equations(), reordered(lagging, SWAPPED))
    (fault,) = checked.faults
    assert "motor2 acts as the model's motor1, motor1 acts as the model's motor2" in fault.evidence
    assert "let motor1, motor2 read the columns that motor2, motor1 read now" in fault.fix
    for mine, original in zip(checked.data, lagging, strict=True):
        np.testing.assert_array_equal(mine.action, original.action)


@pytest.mark.slow
def test_rotors_that_turn_the_other_way_are_said_and_undone() -> None:
    data = motor_flights(spin=OTHER_WAY)
    checked = check(equations(), reordered(data, PX4))
    order, spin = checked.faults
    assert "another order" in order.evidence
    assert "--spin 1 -1 1 -1" in spin.fix
    for mine, original in zip(checked.data, data, strict=True):
        np.testing.assert_allclose(mine.action @ MIXER.T, original.action @ MIXER.T * [1, 1, 1, -1], atol=1e-12)
    assert check(equations(OTHER_WAY), data).faults == ()


def test_the_yaw_torque_of_motor_speeds_is_reversed_alone() -> None:
    model = quadrotor(0.03, interface="motors", motors=Motors(thrust=2.9e-8, unit="rad/s"), dt=0.02)
    rng = np.random.default_rng(0)
    log = motor_flights(names=("hover",), seconds=1.0)[0]
    speeds = rng.uniform(1400, 1800, (len(log), 4))
    turned = turned_the_other_way(model, Dataset([replace(log, action=speeds)]))
    assert turned is not None
    before, after = (np.square(one) @ MIXER.T for one in (speeds, turned[0].action))
    np.testing.assert_allclose(after, before * [1, 1, 1, -1], rtol=1e-9)


def test_rotors_that_stand_at_first_are_told_how_they_turn() -> None:
    model = quadrotor(0.03, interface="motors", motors=Motors(thrust=2.9e-8, unit="rad/s", spin=OTHER_WAY), dt=0.02)
    log = motor_flights(names=("hover",), seconds=0.2)[0]
    speeds = np.full((len(log), 4), 1600.0)
    speeds[:3] = 0.0
    assert "--spin -1 1 -1 1" in spin_text(model, Dataset([replace(log, action=speeds)]))[1]


def test_rotors_that_would_have_to_pull_are_not_turned() -> None:
    model = quadrotor(0.03, interface="motors", motors=Motors(thrust=2.9e-8, unit="rad/s"), dt=0.02)
    log = motor_flights(names=("hover",), seconds=0.2)[0]
    speeds = np.full((len(log), 4), 1600.0)
    speeds[3] = [2000.0, 900.0, 0.0, 1400.0]
    assert turned_the_other_way(model, Dataset([replace(log, action=speeds)])) is None


def test_a_model_without_rates_has_no_order() -> None:
    model = quadrotor(0.03, interface="motors", attitude="measured")
    spec = "crazyflie_battery_drag"
    assert order_of_motors(model, read_logs(example_flight(), spec, model.layouts, model.dt)) is None


def test_the_real_flight_of_the_repository() -> None:
    model = equations()
    data = read_logs(example_flight(), "crazyflie_battery_drag", model.layouts, model.dt)
    assert order_of_motors(model, data) is None
    for order in ORDERS[1:]:
        found = order_of_motors(model, reordered(data, order))
        assert found is not None, order
        assert [order[column] for column in found.columns] == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("folder", "spin"), [("crazyflie_battery_drag", (-1, 1, -1, 1)), ("quadrotor_wind", OTHER_WAY)]
)
def test_other_real_flights(shared_data: Path, folder: str, spin: tuple[int, ...]) -> None:
    for path in sorted((shared_data / folder).glob("*.csv")):
        model = equations(spin)
        assert order_of_motors(model, read_logs(path, folder, model.layouts, model.dt)) is None, path.stem
