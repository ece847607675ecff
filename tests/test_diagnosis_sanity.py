"""Sensors and frames that are wrong in a known way are named with their value, and undone; honest logs stay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from noisy_flights import flights_with
from standard_set import Case, simulate_case

from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, add, compare
from sym2real.diagnosis.faults.sanity import check
from sym2real.diagnosis.faults.sensor_readings import readings
from sym2real.diagnosis.predict.candidate import library_for
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.question import Question, check_data
from sym2real.experiments import standard_conditions
from sym2real.experiments.flying import fly
from sym2real.layout import Layout
from sym2real.logs.differences import rates_on_time
from sym2real.logs.noise import component_noise
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory


def changed(data: Dataset, column: str, change: Callable[[Array], Array]) -> Dataset:
    """Logs with a column of the state as a broken sensor writes it."""
    return Dataset(log.with_columns({column: change(log.column(column))}) for log in data)


def plain() -> Dataset:
    return flights_with("", {})


def test_honest_logs_have_no_fault_and_are_looked_at_once() -> None:
    model, honest = CRAZYFLIE.nominal(), plain()
    checked = check(model, honest)
    assert checked.faults == ()
    assert check(model, Dataset(list(honest))) is checked
    assert check(MUSHR.nominal(), simulate_case(Case("mushr", (), seed=4), rows=200)).faults == ()


def test_logs_without_names_and_with_one_name_are_told_apart() -> None:
    """What a simulator says of a log is found by its name; of logs with one name it would be their mean."""
    data, model = simulate_case(Case("mushr", (), seed=4), 4, 100), MUSHR.nominal()
    named = Dataset(replace(log, name=name) for log, name in zip(data, ("", "drive", "", "drive"), strict=True))
    names = [log.name for log in check_data(Question(model, named)).checked.data]
    assert names == ["log 1", "drive", "log 3", "drive (4)"]
    assert [log.name for log in check_data(Question(model, data)).checked.data] == [log.name for log in data]


@pytest.mark.slow
def test_what_the_model_says_of_its_sensors_is_no_fault_and_its_absence_is() -> None:
    turned = changed(plain(), "wy", lambda rate: -rate)
    knowing = add(CRAZYFLIE.nominal(), "sensor_sign:wy", {"value": -1.0})
    checked = check(knowing, turned)
    assert checked.faults == ()
    np.testing.assert_allclose(checked.data[0].state, rates_on_time(turned)[0].state, atol=1e-9)
    mistaken = check(knowing, plain())
    assert [fault.effect for fault in mistaken.faults] == ["sensor_sign:wy"]
    np.testing.assert_allclose(mistaken.data[0].column("wy"), turned[0].column("wy"), atol=1e-9)


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("sensor_sign:wy", {"value": -1.0}),
        ("sensor_scale:x", {"value": 2.0}),
        ("mounting_tilt", {"roll": 0.2, "pitch": -0.1}),
    ],
)
def test_pieces_start_where_the_models_own_sensors_report_what_was_logged(key: str, values: dict[str, float]) -> None:
    model, data = add(CRAZYFLIE.nominal(), key, values), plain()
    library = library_for(model, data, exclude=("*:*",))
    problem = Problem(library, data)
    reported = problem.states(library.null[None])[0, :, 0]
    away = data.layouts.state.difference(reported, problem.segments.start)
    assert float(away.abs().max()) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value", "tolerance"),
    [("sensor_scale:wy", 1.2, 0.03), ("sensor_bias:wx", 0.15, 0.02), ("time_shift:wy", 0.06, 0.006)],
)
def test_a_gyro_that_was_wrong_in_flight_is_settled(key: str, value: float, tolerance: float) -> None:
    checked = check(CRAZYFLIE.nominal(), flights_with(key, {"value": value}))
    (fault,) = checked.faults
    assert fault.effect == key
    assert fault.value == pytest.approx(value, abs=tolerance)
    assert fault.fix
    assert check(CRAZYFLIE.nominal(), checked.data).faults == ()


@pytest.mark.parametrize(
    ("column", "change", "fault"),
    [
        ("vz", lambda v: v + 0.1, "sensor_bias:vz"),
        ("wz", lambda w: -w, "sensor_sign:wz"),
        ("vy", lambda v: -v, "sensor_sign:vy"),
    ],
)
def test_a_column_in_the_wrong_unit_or_sign_is_settled(
    column: str, change: Callable[[Array], Array], fault: str
) -> None:
    data = plain()
    checked = check(CRAZYFLIE.nominal(), changed(data, column, change))
    assert [one.effect for one in checked.faults] == [fault]
    place = data.layouts.state.index(column)
    for mine, original in zip(checked.data, rates_on_time(data), strict=True):
        scatter = np.std(original.state[:, place])
        np.testing.assert_allclose(mine.state[:, place], original.state[:, place], atol=0.05 * max(scatter, 0.2))


@pytest.mark.parametrize("seed", [10, 20])
def test_a_rate_that_swings_between_the_rows_of_a_thinned_log_has_no_scale(seed: int) -> None:
    """Every second row of a rate that chatters from row to row is slow and turns nothing: it told scales of 800."""
    logs = [chattering(seed + number) for number in range(8)]
    for every in (1, 2, 3):
        assert check(MUSHR.nominal(), Dataset(thinned(log, every) for log in logs)).faults == ()


def chattering(seed: int) -> Trajectory:
    rng, time = np.random.default_rng(seed), 0.02 * np.arange(400)
    first, second = rng.uniform(0.0, 2.0 * np.pi, 2)
    yaw = 0.01 * np.sin(0.9 * time + first)
    chatter = 0.5 * np.sin(0.7 * time + second) * (-1.0) ** np.arange(400)
    state = np.zeros((400, MUSHR.layouts.state.size))
    measured = yaw + rng.normal(0.0, 0.003, 400)
    state[:, 2], state[:, 3] = np.sin(measured), np.cos(measured)
    state[:, 6] = np.gradient(yaw, time) + chatter + rng.normal(0.0, 0.02, 400)
    return Trajectory(time, state, np.zeros((400, 2)), np.zeros((400, 0)), replace(MUSHR.layouts, inputs=Layout.of(())))


def thinned(log: Trajectory, every: int) -> Trajectory:
    rows = slice(None, None, every)
    return replace(log, time=log.time[rows], state=log.state[rows], action=log.action[rows], inputs=log.inputs[rows])


def test_a_scale_is_told_as_a_factor_of_the_sensor_and_not_as_a_unit() -> None:
    (fault,) = check(CRAZYFLIE.nominal(), flights_with("sensor_scale:wy", {"value": 1.2})).faults
    assert "deg" not in fault.fix
    assert "mm" not in fault.fix
    assert "calibrate" in fault.fix


@pytest.mark.parametrize("times", [0.6, 1.8, 10.0])
@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR])
def test_stamps_of_a_wrong_clock_are_told_as_such_and_not_as_many_sensors(robot: Robot, times: float) -> None:
    """What is written at another rate than the file says moves and turns by as much more, all of it alike."""
    data = plain() if robot is CRAZYFLIE else simulate_case(Case("mushr", (), seed=4), 4, 200)
    checked = check(robot.nominal(), Dataset(replace(log, time=times * log.time) for log in data))
    (fault,) = checked.faults
    assert fault.name == "the clock"
    assert float(fault.fix.split("by ")[1].split(",")[0]) == pytest.approx(1 / times, rel=0.05)
    seconds = [log.time[-1] - log.time[0] for log in data]
    assert [log.time[-1] - log.time[0] for log in checked.data] == pytest.approx(seconds, rel=0.02)
    assert checked.data.dt == pytest.approx(robot.dt, rel=0.02)


def test_a_model_of_one_scale_for_every_sensor_is_no_clock() -> None:
    """A gyro alone that is off about all its axes leaves the velocities, which know the clock, as they are."""
    data = plain()
    for column in ("wx", "wy", "wz"):
        data = changed(data, column, lambda w: 1.3 * w)
    assert [one.effect for one in check(CRAZYFLIE.nominal(), data).faults] == [
        f"sensor_scale:{column}" for column in ("wx", "wy", "wz")
    ]


@pytest.mark.slow
def test_sensors_that_were_found_wrong_are_in_the_model() -> None:
    """It predicts what they report: the same logs then show no fault, with a bias and a scale of one sensor too."""
    base, raw = CRAZYFLIE.nominal(), changed(changed(plain(), "wy", lambda w: 1.3 * w + 0.2), "wx", lambda w: -w)
    checked = check(base, raw)
    informed = Diagnosis("EFFECT", "", faults=checked.faults).apply(base)
    assert {key for key, _ in informed.effects} == {"sensor_sign:wx", "sensor_bias:wy", "sensor_scale:wy"}
    assert check(informed, raw).faults == ()
    errors = [compare(model, raw, horizons=(0.1,)).at(0.1).errors["rate"].value for model in (base, informed)]
    right = compare(base, plain(), horizons=(0.1,)).at(0.1).errors["rate"].value
    assert errors[1] == pytest.approx(right, rel=0.3)
    assert errors[0] > 3.0 * right


def test_a_cars_gyro_is_settled_from_its_heading() -> None:
    data = simulate_case(Case("mushr", (), seed=4), rows=200)
    checked = check(MUSHR.nominal(), changed(data, "wz", lambda w: 0.8 * w + 0.1))
    assert {one.effect: pytest.approx(one.value, rel=0.1) for one in checked.faults} == {
        "sensor_scale:wz": 0.8,
        "sensor_bias:wz": 0.1,
    }


@pytest.mark.parametrize("rows", [1, 2, 3, 9])
def test_a_piece_of_a_few_rows_hides_no_fault_and_changes_no_noise(rows: int) -> None:
    """Dropouts cut logs wherever they are; three rows have no third difference."""
    data = changed(simulate_case(Case("mushr", (), seed=4), rows=200), "wz", lambda w: 0.8 * w)
    pieces = Dataset([*data, data[0].rows(0, rows)])
    assert readings(pieces) == readings(data) != ()
    np.testing.assert_array_equal(component_noise(pieces), component_noise(data))
    assert readings(Dataset([data[0].rows(0, rows)])) == ()


def one_circle(seed: int, seconds: float) -> Trajectory:
    task, noise = make_task("circle", MUSHR), standard_conditions.sensors(MUSHR, np.random.default_rng(seed))
    controller = geometric_controller(MUSHR, task.reference)
    return fly(MujocoPlant(MUSHR, [noise]), controller, task, seconds=seconds).trajectory


@pytest.mark.parametrize("seed", range(4))
def test_one_circle_of_a_healthy_car_shows_no_fault_of_its_gyro(seed: int) -> None:
    """The rate hardly changes, so that noise alone decides what scale, bias and shift fit best."""
    assert readings(Dataset([one_circle(seed, 15.0)])) == ()


def test_a_bias_is_told_with_how_sure_it_is() -> None:
    biased = changed(flights_with("", {}), "wx", lambda rate: rate + 0.1)
    (found,) = readings(biased)
    assert abs(found.bias - 0.1) < 3.0 * found.unsure < 0.05
    (fault,) = check(CRAZYFLIE.nominal(), biased).faults
    assert f"is off by {found.bias:.3g} ± {1.96 * found.unsure:.1g} from" in fault.evidence


@pytest.mark.parametrize("first", [1000, 1012])
def test_many_circles_of_a_healthy_car_show_no_fault_and_one_that_is_there(first: int) -> None:
    """A lag too small to be one fits noise best: scale and bias are not read at it."""
    circles = Dataset(one_circle(seed, 20.0) for seed in range(first, first + 6))
    assert readings(circles) == ()
    (found,) = readings(changed(circles, "wz", lambda rate: rate + 0.3))
    assert found.faulty == {"sensor_bias": pytest.approx(0.3, abs=0.06)}


def answered_noise(seed: int, swing: float, late: int) -> Trajectory:
    """A car on a circle that steers against the noise of its measured heading; its gyro is so many rows late.

    Args:
        seed: of the noise.
        swing: amplitude of the turn rate about that of the circle, rad/s.
        late: rows.
    """
    rng, rows, dt = np.random.default_rng(seed), 300, 0.05
    heading_noise = 0.005 * rng.standard_normal(rows)
    rate = 0.5 + swing * np.sin(2.0 * dt * np.arange(rows)) - 4.0 * np.roll(heading_noise, 1)
    yaw = dt * np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))])
    along = dt * np.stack([np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))], axis=1)
    measured = yaw + heading_noise
    gyro = np.roll(rate, late) + 0.02 * rng.standard_normal(rows)
    state = np.column_stack(
        [along, np.sin(measured), np.cos(measured), np.cos(yaw), np.sin(yaw), gyro],
    )
    action = np.column_stack([np.full(rows, 0.15), np.ones(rows)])
    inputs = np.zeros((rows, MUSHR.layouts.inputs.size))
    return Trajectory(dt * np.arange(rows), state, action, inputs, MUSHR.layouts, name=f"circle {seed}")


@pytest.mark.parametrize("seed", range(8))
def test_a_controller_that_answers_a_noisy_heading_is_no_late_gyro(seed: int) -> None:
    honest = Dataset([answered_noise(seed, 0.0, late=0), answered_noise(100 + seed, 0.0, late=0)])
    assert [one.faulty for one in readings(honest) if one.column == "wz"] == []
    late = Dataset([answered_noise(seed, 0.4, late=3), answered_noise(100 + seed, 0.4, late=3)])
    (shift,) = [one.shift for one in readings(late) if one.column == "wz"]
    assert shift == pytest.approx(0.15, abs=0.03)
