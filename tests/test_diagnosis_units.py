"""Columns in another unit and quaternions in another order are named and undone; what robots do themselves is not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from broken_logs import times
from noisy_flights import flights, flights_with
from real_logs import motor_level_equations
from standard_set import Case, simulate_case

from sym2real import rotation
from sym2real.data import example_flight
from sym2real.dataset import Dataset
from sym2real.diagnosis import add, compare, diagnose
from sym2real.diagnosis.faults.fault import Breach
from sym2real.diagnosis.faults.foreign_units import BY_SENSORS, Steps
from sym2real.diagnosis.faults.misread_attitudes import ORDERS, QUATERNION, other_angles
from sym2real.diagnosis.faults.mistakes.rows import BadRows
from sym2real.diagnosis.faults.mistakes.transformation import OtherAxes
from sym2real.diagnosis.faults.sanity import check, looks_for, through
from sym2real.diagnosis.faults.units import Scaled
from sym2real.effects.sensors import Sensors
from sym2real.logs import read_log, write_log
from sym2real.logs.agreement import thrust_agreement
from sym2real.logs.differences import rates_on_time
from sym2real.logs.pose import attitude, with_angles
from sym2real.logs.sources import AsRead
from sym2real.robots import CRAZYFLIE, MUSHR, Robot, car, quadrotor
from sym2real.symbolic import Equations
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import ATTITUDE, RATE

DEGREES = 180.0 / np.pi
Factors = dict[str, float]


def breaches(data: Dataset, model: Equations | None = None) -> tuple[list[Breach | BadRows], Dataset]:
    """What stands against the conventions alone, and the logs without it."""
    data = data if model is None else through(Sensors(model).state, data)
    found: list[Breach | BadRows] = []
    for look in chain.from_iterable(looks_for(model)):
        for breach in look(data):
            data = breach.undone(data)
            found.append(breach)
    return found, data


def scaled(breach: Breach | BadRows) -> Scaled:
    """What a breach says of a scale."""
    assert isinstance(breach, Breach)
    assert isinstance(breach.transformation, Scaled)
    return breach.transformation


def one_flight() -> Dataset:
    """A single circle of 4 s: what a user tries first."""
    return Dataset([flights()[1]])


@cache
def drives() -> Dataset:
    return simulate_case(Case("mushr", (), seed=4), 2, 150)


@cache
def short_drives() -> Dataset:
    """All eight references of the standard set."""
    return simulate_case(Case("mushr", (), seed=0), 8, 150)


def in_order(order: str, data: Dataset) -> Dataset:
    held = dict(zip(QUATERNION, ORDERS[order][1], strict=True))
    return Dataset(log.with_columns({own: log.column(other) for own, other in held.items()}) for log in data)


def of(columns: str, factor: float) -> Factors:
    return dict.fromkeys(columns.split(), factor)


QUADROTOR = [
    (of("x y z", 1e3), ["x y z in mm instead of m"]),
    (of("x y z", 1e2) | of("vx vy vz", 1e2), ["x y z in cm instead of m", "vx vy vz in cm/s instead of m/s"]),
    (
        of("x y z vx vy vz", 1e3) | of("wx wy wz", DEGREES),
        ["x y z in mm instead of m", "vx vy vz in mm/s instead of m/s", "wx wy wz in deg/s instead of rad/s"],
    ),
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
    (of("wz", DEGREES), ["sensor_scale:wz (57.3)"]),
    (of("steer", DEGREES), ["steer in deg instead of rad"]),
    (of("steer", -DEGREES), ["steer in deg instead of rad", "steer with the wrong sign"]),
    (of("speed", 1e3), ["speed in mm/s instead of m/s"]),
]


SMALL = [
    (CRAZYFLIE, of("x y z", 1e-3), ["x y z in m that are read as mm"]),
    (CRAZYFLIE, of("vx vy vz", 1e-2), ["vx vy vz in m/s that are read as cm/s"]),
    (CRAZYFLIE, of("wx wy wz", 1.0 / DEGREES), ["wx wy wz in rad/s that are read as deg/s"]),
    (CRAZYFLIE, of("wx_cmd wy_cmd wz_cmd", 1.0 / DEGREES), ["wx_cmd wy_cmd wz_cmd in rad/s that are read as deg/s"]),
    (CRAZYFLIE, of("thrust", 1e-3), ["thrust in N that are read as mN"]),
    (MUSHR, of("steer", 1.0 / DEGREES), ["steer in rad that are read as deg"]),
    (MUSHR, of("speed", 1e-3), ["speed in m/s that are read as mm/s"]),
]


LARGE = [(CRAZYFLIE, *one) for one in QUADROTOR] + [(MUSHR, *one) for one in CAR]


@pytest.mark.parametrize(("robot", "factors", "said"), LARGE + SMALL)
def test_another_unit_is_named_and_undone(robot: Robot, factors: Factors, said: list[str]) -> None:
    data = one_flight() if robot is CRAZYFLIE else drives()
    checked = check(robot.nominal(), times(data, factors))
    assert sorted(fault.name for fault in checked.faults) == sorted(said)
    assert all("unit = " in fault.fix or "flip" in fault.fix for fault in checked.faults)
    for log, right in zip(checked.data, rates_on_time(data), strict=True):
        np.testing.assert_allclose(log.state, right.state, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(log.action, right.action, rtol=1e-9, atol=1e-12)


def test_steering_in_degrees_with_the_other_sign_is_named_by_a_model_that_obeys_at_once() -> None:
    """Its steering moves nothing while it stands."""
    model = car(MUSHR.numbers["wheelbase"], mass=MUSHR.mass, dt=MUSHR.dt)
    data = drives()
    checked = check(model, times(data, of("steer", -DEGREES)))
    assert [f.name for f in checked.faults] == ["steer in deg instead of rad", "steer with the wrong sign"]
    np.testing.assert_allclose(checked.data[0].action, data[0].action, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ({}, []),
        (of("wx", -DEGREES) | of("wy wz", DEGREES), ["wx wy wz in deg/s instead of rad/s", "sensor_sign:wx"]),
    ],
)
def test_the_scalar_last_is_named_beside_units_and_signs(factors: Factors, said: list[str]) -> None:
    data = one_flight()
    checked = check(CRAZYFLIE.nominal(), in_order("xyzw", times(data, factors)))
    assert [fault.name for fault in checked.faults] == ["quaternions with the scalar last (x y z w)", *said]
    np.testing.assert_allclose(checked.data[0].state, rates_on_time(data)[0].state, rtol=1e-9, atol=1e-12)


def test_the_scalar_last_is_named_where_the_attitude_is_an_input() -> None:
    """The model predicts neither the attitude nor the rates, which stand beside it."""
    model = quadrotor(CRAZYFLIE.mass, attitude="measured", dt=CRAZYFLIE.dt)

    def given(log: Trajectory) -> Trajectory:
        known = {name: log.column(name) for names in log.layouts.groups.values() for name in names}
        parts = (
            np.stack([known.get(name, np.zeros(len(log))) for name in names], axis=1)
            for names in model.layouts.groups.values()
        )
        return Trajectory(log.time, *parts, model.layouts, {name: known[name] for name in RATE.columns})

    right, last = (Dataset(map(given, data)) for data in (one_flight(), in_order("xyzw", one_flight())))
    assert check(model, right).faults == ()
    checked = check(model, last)
    assert [fault.name for fault in checked.faults] == ["quaternions with the scalar last (x y z w)"]
    np.testing.assert_allclose(checked.data[0].inputs, right[0].inputs, atol=1e-12)


def test_the_scalar_first_in_columns_of_x_y_z_w_is_named_and_the_fix_reads_it() -> None:
    data = one_flight()
    checked = check(CRAZYFLIE.nominal(), in_order("wxyz", data))
    assert [fault.name for fault in checked.faults] == [ORDERS["wxyz"][0]]
    assert 'quaternion = ["qx", "qy", "qz", "qw"] and order = "wxyz"' in checked.faults[0].fix
    np.testing.assert_allclose(checked.data[0].state, rates_on_time(data)[0].state, rtol=1e-9, atol=1e-12)


def angles_times(data: Dataset, factor: float) -> Dataset:
    """Attitudes, or headings, made of angles in another unit."""
    logs = []
    for log in data:
        angles = np.unwrap(rotation.to_euler(attitude(log)).numpy(), axis=0)
        logs.append(with_angles(log, factor * (angles if log.layouts.state.has_field("attitude") else angles[:, 2:])))
    return Dataset(logs)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (DEGREES, "an attitude in degrees that is read as radians"),
        (1.0 / DEGREES, "an attitude in radians that is read as degrees"),
    ],
)
@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR])
def test_angles_in_another_unit_are_named_and_the_gyro_is_not(robot: Robot, factor: float, said: str) -> None:
    """Of angles that are 57 times too large whole turns are lost; rates count them, all but one of the heading."""
    data = Dataset(flights()[:3]) if robot is CRAZYFLIE else drives()
    checked = check(robot.nominal(), angles_times(data, factor))
    assert [fault.name for fault in checked.faults] == [said]
    for log, right in zip(checked.data, rates_on_time(data), strict=True):
        off = rotation.logarithm(rotation.multiply(attitude(log), rotation.conjugate(attitude(right)))).numpy()
        np.testing.assert_allclose(off[:, :2], 0.0, atol=1e-6)
        np.testing.assert_allclose(off[:, 2], off[0, 2], atol=1e-6)
        assert abs(off[0, 2]) < (1.01 * 2.0 * np.pi / DEGREES if factor > 1.0 else 1e-6)


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR])
def test_angles_and_rates_that_are_both_in_degrees_are_told(robot: Robot) -> None:
    """They agree with each other as they stand; where the robot goes, or is pushed, agrees with neither."""
    data = Dataset(flights()[:3]) if robot is CRAZYFLIE else drives()
    rates = [name for name in ("wx", "wy", "wz") if name in robot.layouts.state]
    broken = times(angles_times(data, DEGREES), dict.fromkeys(rates, DEGREES))
    checked = check(robot.nominal(), broken)
    assert [fault.name for fault in checked.faults] == [
        "wx wy wz in deg/s instead of rad/s" if robot is CRAZYFLIE else "sensor_scale:wz (57.3)",
        "an attitude in degrees that is read as radians",
    ]
    for log, right in zip(checked.data, rates_on_time(data), strict=True):
        off = rotation.logarithm(rotation.multiply(attitude(log), rotation.conjugate(attitude(right)))).numpy()
        np.testing.assert_allclose(off[:, 2], off[0, 2], atol=1e-6)
        np.testing.assert_allclose(log.column("wz"), right.column("wz"), rtol=1e-9)


def test_a_specification_says_the_unit_of_its_angles() -> None:
    read = AsRead({"roll": "Roll", "pitch": "Pitch", "yaw": "Yaw"})
    (found,) = other_angles(angles_times(drives(), DEGREES))
    assert found.fix(read) == 'say unit = "deg" of Roll Pitch Yaw in a specification of the log'
    assert found.fix(AsRead()).endswith("of angles in rad")


@pytest.mark.parametrize("factor", [70_000.0, 1.0 / 25.0], ids=["large", "part of the most"])
def test_a_factor_of_no_unit_is_told_with_the_scale_that_undoes_it(factor: float) -> None:
    data = one_flight()
    (found,), mended = breaches(times(data, {"thrust": factor}), CRAZYFLIE.nominal())
    assert scaled(found).unit == ""
    assert scaled(found).factor == pytest.approx(factor, rel=0.05)
    assert f"scale = {1.0 / scaled(found).factor:.4g}" in found.fix(AsRead())
    np.testing.assert_allclose(mended[0].action, data[0].action, rtol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "column", "key", "values"),
    [
        (CRAZYFLIE, "wy_cmd", "", {}),
        (CRAZYFLIE, "wz_cmd", "added_mass", {"value": 0.004}),
        (MUSHR, "steer", "offset:steer", {"value": 0.06}),
        (MUSHR, "steer", "delay", {"value": 0.2}),
        (MUSHR, "speed", "", {}),
    ],
)
def test_a_command_with_the_wrong_sign_is_named_and_undone(
    robot: Robot, column: str, key: str, values: Factors
) -> None:
    data = logs_with(robot, key, values)
    checked = check(robot.nominal(), times(data, {column: -1.0}))
    assert [fault.name for fault in checked.faults] == [f"{column} with the wrong sign"]
    for log, right in zip(checked.data, rates_on_time(data), strict=True):
        np.testing.assert_array_equal(log.action, right.action)


def test_a_wrong_sign_among_commands_in_another_unit_hides_none_of_both() -> None:
    """Of three commands that share a unit, one against the model: as many factors mend two as mend the third."""
    data, commands = logs_with(CRAZYFLIE, "", {}), "wx_cmd wy_cmd wz_cmd"
    checked = check(CRAZYFLIE.nominal(), times(data, of(commands, DEGREES) | {"wy_cmd": -DEGREES}))
    said = [f"{commands} in deg/s instead of rad/s", "wy_cmd with the wrong sign"]
    assert [fault.name for fault in checked.faults] == said
    for log, right in zip(checked.data, data, strict=True):
        np.testing.assert_allclose(log.action, right.action, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("factor", "unit"), [(100.0, "%"), (65535.0, "uint16")])
def test_motors_in_percent_or_16_bits_are_named_on_a_measured_flight(factor: float, unit: str) -> None:
    flight, name = example_flight(), "crazyflie_battery_drag"
    model = motor_level_equations(flight, name)
    data = Dataset([read_log(flight, spec=name, layouts=model.layouts, dt=model.dt)])
    motors = "motor1 motor2 motor3 motor4"
    assert breaches(data, model)[0] == []
    (found,), mended = breaches(times(data, of(motors, factor)), model)
    assert (" ".join(scaled(found).columns), scaled(found).unit) == (motors, unit)
    np.testing.assert_allclose(mended[0].action, data[0].action, rtol=1e-9)


def test_logs_in_different_units_are_each_put_right() -> None:
    first, second = flights()[1], flights()[2]
    broken = [*times(Dataset([first]), of("thrust", 1e3)), *times(Dataset([second]), of("wx wy wz", DEGREES))]
    named = [replace(log, name=name) for log, name in zip(broken, ("one", "two"), strict=True)]
    checked = check(CRAZYFLIE.nominal(), Dataset(named))
    assert [fault.name for fault in checked.faults] == [
        "wx wy wz in deg/s instead of rad/s in two, other than in other logs",
        "thrust in mN instead of N in one, other than in other logs",
    ]
    for log, right in zip(checked.data, rates_on_time(Dataset([first, second])), strict=True):
        np.testing.assert_allclose(log.state, right.state, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(log.action, right.action, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_logs_that_agree_are_judged_together_even_if_one_alone_is_unclear() -> None:
    """A centre of mass that is off needs a rate command at rest, which is no factor of what was sent."""
    data = flights_with("com_offset", {"rx": 0.001}, count=4)
    checked = check(CRAZYFLIE.nominal(), times(data, of("wx_cmd wy_cmd wz_cmd", DEGREES)))
    assert [fault.name for fault in checked.faults] == ["wx_cmd wy_cmd wz_cmd in deg/s instead of rad/s"]


EFFECTS = [
    (CRAZYFLIE, "gain:thrust", {"value": 0.6}),
    (CRAZYFLIE, "gain:wx_cmd", {"value": 0.2}),
    (CRAZYFLIE, "delay", {"value": 0.1}),
    (CRAZYFLIE, "added_mass", {"value": 0.015}),
    (CRAZYFLIE, "wind", {"fx": 0.08}),
    (MUSHR, "limit:speed", {"upper": 0.2}),
    (MUSHR, "gain:speed", {"value": 0.3}),
    (MUSHR, "lag:speed", {"value": 1.0}),
]


def logs_with(robot: Robot, key: str, values: Factors) -> Dataset:
    if robot is CRAZYFLIE:
        return flights_with(key, values, count=2)
    return simulate_case(Case("mushr", ((key, values),) if key else (), seed=4), 3, 200)


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "key", "values"), EFFECTS)
def test_a_strong_effect_is_no_other_unit_whether_the_model_has_it_or_not(
    robot: Robot, key: str, values: Factors
) -> None:
    data, plain = logs_with(robot, key, values), robot.nominal()
    for log in data:
        assert breaches(Dataset([log]), plain)[0] == []
    assert breaches(data, plain)[0] == []
    assert breaches(data, add(plain, key, values))[0] == []


def test_commands_of_a_model_with_filters_are_judged_behind_them() -> None:
    late = ("delay", {"value": 0.1})
    data, model = simulate_case(Case("mushr", (late,), seed=4), 2, 150), add(MUSHR.nominal(), *late)
    (found,), _ = breaches(times(data, {"steer": DEGREES}), model)
    assert (scaled(found).columns, scaled(found).unit) == (("steer",), "deg")
    behind, before = Steps.of(model, data), Steps.of(MUSHR.nominal(), data)
    assert behind is not None
    assert before is not None
    assert behind.missed((), 1.0) < 0.5 * before.missed((), 1.0)


@pytest.mark.parametrize(("noise", "columns"), [(1.0, "wx wy wz"), (3.0, "vx vy vz")])
def test_a_noisy_sensor_is_in_no_other_unit(noise: float, columns: str) -> None:
    rng, noisy = np.random.default_rng(0), []
    for log in flights():
        state = log.state.copy()
        state[:, log.layouts.state.indices(columns.split())] += noise * rng.normal(size=(len(log), 3))
        noisy.append(replace(log, state=state))
    assert breaches(Dataset(noisy), CRAZYFLIE.nominal())[0] == []
    assert breaches(Dataset(noisy[:1]), CRAZYFLIE.nominal())[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("rows", [30, 150])
def test_velocities_along_body_axes_are_no_positions_in_another_unit(rows: int) -> None:
    for log in short_drives():
        turned = Dataset([OtherAxes(("vx", "vy"), "world").undone(log).rows(0, rows)])
        assert breaches(turned, None)[0] == []
        assert not any(
            "instead of" in fault.name or "unit" in fault.name for fault in check(MUSHR.nominal(), turned).faults
        )


def test_a_turn_of_many_times_gravity_is_no_other_unit() -> None:
    """A circle of 6 m at 22 m/s, whose thrust is eight times the weight."""
    radius, speed, log = 6.0, 22.0, flights()[1]
    angle = speed / radius * log.time
    east, north, nothing = np.cos(angle), np.sin(angle), np.zeros(len(log))
    lean = np.arctan2(speed**2 / radius, 9.81)
    # Thrust points up and inwards: a turn by the lean about the way forwards, against its sense.
    attitude = np.stack(
        [nothing + np.cos(lean / 2), np.sin(lean / 2) * north, -np.sin(lean / 2) * east, nothing], axis=1
    )
    columns = {
        "x": radius * east,
        "y": radius * north,
        "z": nothing,
        "vx": -speed * north,
        "vy": speed * east,
        "vz": nothing,
    }
    noise = 5e-4 * np.random.default_rng(0).normal(size=len(log))
    measured = {name: values + noise for name, values in columns.items()}
    turn = log.with_columns(measured | dict(zip(ATTITUDE.columns, attitude.T, strict=True)))
    assert thrust_agreement([turn]).correlation == pytest.approx(1.0, abs=0.02)
    assert not any(look(Dataset([turn])) for look in BY_SENSORS[:2])


def test_a_robot_at_rest_has_no_commands_in_another_unit() -> None:
    log, rng = flights()[1], np.random.default_rng(0)
    for noise in (0.0, 1e-3):
        state = np.tile(log.state[:1], (len(log), 1)) + noise * rng.normal(size=log.state.shape)
        assert breaches(Dataset([replace(log, state=state)]), CRAZYFLIE.nominal())[0] == []


@pytest.mark.parametrize(
    ("column", "factor", "unit"), [("x", 1e3, "mm"), ("z", 1e3, "mm"), ("wy", DEGREES, "deg/s"), ("vz", 1e2, "cm/s")]
)
def test_one_column_of_several_is_named_alone(column: str, factor: float, unit: str) -> None:
    (found,), mended = breaches(times(flights(), {column: factor}))
    assert (scaled(found).columns, scaled(found).unit) == ((column,), unit)
    np.testing.assert_allclose(mended[0].state, flights()[0].state, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("factors", "lines"),
    [
        (
            of("thrust", 1.0 / CRAZYFLIE.mass),
            ["mass = 0.027", "[columns]", 'thrust = { column = "thrust", unit = "m/s^2" }'],
        ),
        (
            of("wx wy wz", DEGREES),
            ["[columns]", *(f'{w} = {{ column = "{w}", unit = "deg/s" }}' for w in ("wx", "wy", "wz"))],
        ),
    ],
)
def test_the_fix_mends_the_log(tmp_path: Path, factors: Factors, lines: list[str]) -> None:
    (log,) = times(one_flight(), factors)
    (fault,) = check(CRAZYFLIE.nominal(), Dataset([log])).faults
    assert all(part in fault.fix for part in ("unit = ", *(["mass = 0.027"] if "mass" in lines[0] else [])))
    write_log(log, tmp_path / "log.csv")
    time = ["[time]", 'column = "time"']
    place = lines.index("[columns]")
    (tmp_path / "spec.toml").write_text("\n".join([*lines[:place], *time, *lines[place:]]))
    model = CRAZYFLIE.nominal()
    mended = read_log(tmp_path / "log.csv", spec=tmp_path / "spec.toml", layouts=model.layouts, dt=model.dt)
    assert check(model, Dataset([mended])).faults == ()


def test_sound_logs_of_both_robots_and_a_hover_alone_have_no_breach() -> None:
    assert breaches(flights(), CRAZYFLIE.nominal())[0] == []
    assert breaches(Dataset([flights()[0]]), CRAZYFLIE.nominal())[0] == []
    assert breaches(drives(), MUSHR.nominal())[0] == []


@pytest.mark.slow
def test_compare_and_diagnose_say_it_and_nothing_else_is_missing() -> None:
    broken, model = times(flights(), of("wx wy wz", DEGREES)), CRAZYFLIE.nominal()
    lines = compare(model, broken).data.lines()
    assert [line for line in lines if "deg/s" in line] == [line for line in lines if "instead of" in line] != []
    found = diagnose(model, broken, exclude=("*:*",))
    assert found.verdict == "EFFECT"
    assert found.findings == ()
    assert found.summary.startswith("The data show wx wy wz in deg/s instead of rad/s")
