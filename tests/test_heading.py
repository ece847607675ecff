"""Headings in another unit, sense or zero than their name says, by the way the car moves; honest ones stay."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kinematic_car import car, drive
from log_files import saved
from standard_set import Case, simulate_case

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.misread_attitudes import against_the_path
from sym2real.diagnosis.faults.report import data_report
from sym2real.diagnosis.faults.sanity import check
from sym2real.logs import Inspection, LogSpec, inspect_logs, read_log, read_logs, write_log
from sym2real.logs.course import between, course, together
from sym2real.logs.pose import with_angles
from sym2real.robots import MUSHR
from sym2real.trajectory import Array

TIME, POSITION, YAW, SPEED, STEER = car()
WRAPPED = (YAW + np.pi) % (2 * np.pi) - np.pi
COMPASS = (90 - np.degrees(YAW)) % 360


def logged(folder: Path, name: str, heading: Array, servo: float = 1.0, **more: Array) -> Inspection:
    columns = {"servo_us": np.round(1500 + servo * 1000 * STEER), "speed_setpoint": SPEED, **more}
    return inspect_logs(saved(folder, drive(**{name: heading}, **columns), "car.csv"))


def evidence(found: Inspection) -> str:
    return next(row.evidence for row in found.rows if row.meaning == "yaw")


@pytest.mark.parametrize(
    ("name", "heading", "unit"),
    [
        ("heading_deg", WRAPPED, ""),
        ("heading_deg", YAW, ""),
        ("heading_deg", np.degrees(WRAPPED), "deg"),
        ("heading_rad", np.degrees(YAW), "deg"),
        ("heading_rad", YAW, ""),
        ("heading", 3 * np.pi + YAW, ""),
        ("heading", np.degrees(YAW), "deg"),
    ],
)
def test_the_path_tells_the_unit(tmp_path: Path, name: str, heading: Array, unit: str) -> None:
    found = logged(tmp_path, name, heading)
    assert found.spec.columns["yaw"].unit == unit
    assert found.suspected_flips == ()
    wrong = {"heading_deg": "deg", "heading_rad": "rad"}.get(name) not in (None, unit or "rad")
    assert ("the name says" in evidence(found)) == wrong
    assert ("# the name says" in found.toml()) == wrong


@pytest.mark.parametrize("servo", [1.0, -1.0])
def test_a_heading_against_the_path_is_blamed_on_nothing_else(tmp_path: Path, servo: float) -> None:
    found = logged(tmp_path, "heading", -WRAPPED, servo, gyro_z=np.gradient(YAW, TIME))
    assert found.suspected_flips == ("heading",)
    turned_gyro = logged(tmp_path, "heading", -WRAPPED, servo, gyro_z=-np.gradient(YAW, TIME))
    assert set(turned_gyro.suspected_flips) == {"heading", "gyro_z"}
    assert logged(tmp_path, "heading", WRAPPED, servo).suspected_flips == ()


def test_a_place_against_heading_gyro_and_steering_is_mirrored_itself(tmp_path: Path) -> None:
    """Counted the other way, or x and y in each other's place: three sensors are right."""
    told = {"heading": WRAPPED, "gyro_z": np.gradient(YAW, TIME), "steering_angle": STEER, "speed_setpoint": SPEED}
    swapped = drive(**told)
    swapped["x"], swapped["y"] = swapped["y"], swapped["x"]
    found = inspect_logs(saved(tmp_path, swapped, "car.csv"))
    assert found.suspected_flips == ()
    lines = [line for line in found.toml().splitlines() if line not in ('x = "x"', 'y = "y"')]
    accepted = "\n".join(line[2:] if line in ('# x = "y"', '# y = "x"') else line for line in lines)
    log = read_log(tmp_path / "car.csv", LogSpec.parse(accepted))
    np.testing.assert_allclose(np.stack([log.column("x"), log.column("y")], 1), POSITION, atol=1e-6)
    mirrored = drive(**told)
    mirrored["y"] = -mirrored["y"]
    assert inspect_logs(saved(tmp_path, mirrored, "car.csv")).suspected_flips == ("y",)


def test_a_compass_is_read_as_it_counts(tmp_path: Path) -> None:
    found = logged(tmp_path, "heading_deg", COMPASS)
    assert found.suspected_flips == ("heading_deg",)
    lines = found.toml().splitlines()
    (recorded,), (proposed,) = ([line for line in lines if line.startswith(start)] for start in ("yaw =", "# yaw ="))
    text = found.toml().replace(recorded, proposed[2:]).replace("# flip =", "flip =")
    log = read_log(tmp_path / "car.csv", LogSpec.parse(text))
    np.testing.assert_allclose(log.column("cos_yaw"), np.cos(YAW), atol=0.02)
    np.testing.assert_allclose(log.column("sin_yaw"), np.sin(YAW), atol=0.02)


def test_wraps_tell_the_unit_where_nothing_is_known_of_the_path(tmp_path: Path) -> None:
    for name, heading, unit in (("yaw_deg", 3 * YAW, ""), ("yaw_rad", np.degrees(3 * YAW), "deg")):
        turn = 360.0 if unit else 2 * np.pi
        wrapped = (heading + turn / 2) % turn - turn / 2
        file = saved(tmp_path, {"t": TIME, name: wrapped, "steer": STEER, "speed": SPEED})
        assert inspect_logs(file).spec.columns["yaw"].unit == unit


def test_a_rate_tells_the_unit_of_a_heading_without_path_and_wraps(tmp_path: Path) -> None:
    # A degree or two, which by its size could as well be radians.
    heading = 0.02 * np.sin(TIME)
    for values, unit in ((np.degrees(heading), "deg"), (100 * heading, "")):
        rate = np.gradient(values, TIME) * (1.0 if unit else 180.0 / np.pi)
        columns = {"t": TIME, "heading": values, "gyro_z_deg_s": rate, "steer": STEER, "speed": SPEED}
        assert inspect_logs(saved(tmp_path, columns)).spec.columns["yaw"].unit == unit


def test_a_car_that_reverses_points_against_its_way() -> None:
    way = course(TIME, POSITION[:, 0], POSITION[:, 1], -np.ones(len(TIME)))
    assert between([way], [YAW + np.pi]) == 0.0
    assert abs(between([way], [YAW])) == pytest.approx(np.pi, abs=0.01)


def test_a_straight_drive_tells_nothing() -> None:
    rng = np.random.default_rng(0)
    way = course(TIME, TIME, 0.001 * rng.standard_normal(len(TIME)))
    heading = 0.01 * rng.standard_normal(len(TIME))
    assert together([way], [heading]) > 0.9
    assert together([way], [-heading]) > 0.9


def mirrored(data: Dataset, change: Callable[[Array], Array]) -> Dataset:
    headings = (np.arctan2(log.column("sin_yaw"), log.column("cos_yaw")) for log in data)
    return Dataset(with_angles(log, change(own)[:, None]) for log, own in zip(data, headings, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("zero", [0.0, np.pi / 2])
def test_a_diagnosis_turns_the_heading_and_leaves_the_steering(zero: float) -> None:
    data = simulate_case(Case("mushr", (), seed=4), rows=200)
    assert not against_the_path(data)
    broken = mirrored(data, lambda heading: zero - heading)
    assert sum("turns against the path" in line for line in data_report(broken).lines()) == 1
    checked = check(MUSHR.nominal(), broken)
    (fault,) = checked.faults
    # Turned against the path and by a quarter, a heading's sine is its cosine.
    assert ("heading counted otherwise" if zero else "turns against the path") in fault.evidence
    for mine, original in zip(checked.data, data, strict=True):
        np.testing.assert_allclose(mine.state, original.state, atol=0.06 if zero else 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["tyre_friction", "yaw_bias", "lateral_slip", "offset:steer"])
def test_what_hides_in_a_car_is_no_turned_heading(effect: str) -> None:
    values = {"tyre_friction": 0.3, "yaw_bias": 0.035, "lateral_slip": 5.0, "offset:steer": 0.1}
    case = Case("mushr", ((effect, {"value": values[effect]}),), seed=1)
    assert not against_the_path(simulate_case(case, rows=200))


def test_measured_drives_turn_with_their_path(shared_data: Path) -> None:
    data = read_logs(shared_data / "mushr_steering_offset", "mushr_steering_offset")
    assert not against_the_path(data)
    assert against_the_path(mirrored(data, lambda heading: -heading))
    assert inspect_logs(shared_data / "mushr_steering_offset").suspected_flips == ()


@pytest.mark.parametrize("servo", [1.0, -1.0])
def test_a_drive_as_this_package_writes_it_is_read_as_it_is(tmp_path: Path, servo: float) -> None:
    """By the proposed specification, that is."""
    (log, _) = simulate_case(Case("mushr", (), seed=3), 2, 240)
    action = log.action * [servo if name == "steer" else 1.0 for name in log.layouts.action]
    write_log(replace(log, action=action), tmp_path / "drive.csv")
    found = inspect_logs(tmp_path / "drive.csv")
    read = read_log(tmp_path / "drive.csv", spec=found.spec, layouts=MUSHR.layouts, dt=MUSHR.dt)
    np.testing.assert_allclose(read.state, log.state, atol=1e-12)
    assert found.suspected_flips == ()
