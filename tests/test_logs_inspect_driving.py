"""A car's commands as its drivers log them: a servo's travel from an end, counts of a motor; what they are worth."""

import re
from pathlib import Path

import numpy as np
import pytest
from kinematic_car import car, drive
from log_files import saved

from sym2real.cli import main
from sym2real.logs import Inspection, LogSpec, inspect_logs, read_log
from sym2real.robots import ROBOTS
from sym2real.trajectory import Array

TIME, _, YAW, SPEED, STEER = car()
WHEELBASE = 0.3  # m
MOST_TURNS = 4614.0  # electrical rpm for 1 m/s, as of an F1TENTH car
CENTRE, TRAVEL = 0.53, 1.21  # of a servo: the middle, and its travel per rad


def logged(folder: Path, steer: Array, speed: Array, **more: Array) -> Inspection:
    return inspect_logs(saved(folder, drive(yaw=YAW, servo=steer, speed_cmd=speed, **more), "car.csv"))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_servos_travel_is_counted_from_where_the_car_goes_straight(tmp_path: Path, sign: float) -> None:
    found = logged(tmp_path, CENTRE + sign * TRAVEL * STEER, SPEED)
    zero, curvature = map(float, re.findall(r"zero = (\S+),.*say: (\S+) ×", found.toml())[0])
    assert zero == pytest.approx(CENTRE, abs=0.01)
    assert curvature * WHEELBASE == pytest.approx(1.0 / TRAVEL, rel=0.1)
    assert "steer" not in found.spec.columns
    assert found.suspected_flips == (() if sign > 0 else ("servo",))


@pytest.mark.parametrize("part", [1.0, 0.4])
def test_the_wheelbase_says_whether_numbers_up_to_one_are_an_angle(tmp_path: Path, part: float) -> None:
    """A driver's -1 to 1, here of 0.4 rad at full lock, would be an angle of a longer car."""
    found = logged(tmp_path, STEER / part, SPEED)
    (steer,) = (row for row in found.rows if row.column == "servo")
    (wheelbase,) = map(float, re.findall(r"rad, if the wheelbase is about (\S+) m; else a driver's", steer.evidence))
    assert steer.confidence == "guess"
    assert wheelbase == pytest.approx(WHEELBASE / part, rel=0.2)  # of larger angles the tangent is larger


def test_the_line_that_is_proposed_for_a_servo_reads_its_angle(tmp_path: Path) -> None:
    found = logged(tmp_path, CENTRE - TRAVEL * STEER, SPEED)
    (line,) = re.findall(r"# (steer = \{.*?\})", found.toml())
    line = re.sub(r"scale = 1\.0", f"scale = {1.0 / TRAVEL}", line)
    text = f'flip = ["servo"]\n[columns]\nx = "x"\ny = "y"\nyaw = "yaw"\nspeed = "speed_cmd"\n{line}\n'
    read = read_log(tmp_path / "car.csv", LogSpec.parse(text))
    np.testing.assert_allclose(read.column("steer"), STEER[: len(read)], atol=0.01)


def test_counts_of_a_motor_are_no_speed_in_metres_a_second(tmp_path: Path) -> None:
    found = logged(tmp_path, STEER, MOST_TURNS * SPEED)
    (scale,) = re.findall(r"# speed = .*scale = (\S+) \}", found.toml())
    assert 1.0 / float(scale) == pytest.approx(MOST_TURNS, rel=0.05)
    assert "speed" not in found.spec.columns


def test_columns_that_are_slower_are_held_with_the_lines_that_wait_for_a_number(tmp_path: Path) -> None:
    slower = np.where(np.arange(len(TIME)) % 3, np.nan, 1.0)
    found = logged(tmp_path, slower * (CENTRE + TRAVEL * STEER), slower * MOST_TURNS * SPEED)
    assert '# hold = ["servo", "speed_cmd"]' in found.toml()
    taken = re.sub(r"^# (hold|steer|speed) = (.*?)  #.*$", r"\1 = \2", found.toml(), flags=re.MULTILINE)
    assert {"steer", "speed"} <= {*read_log(tmp_path / "car.csv", LogSpec.parse(taken)).layouts.action}


@pytest.mark.parametrize(("factor", "unit"), [(1.0, ""), (0.6, ""), (2.0, ""), (3.6, "km/h"), (100.0, "cm/s")])
def test_a_speed_near_that_of_the_path_is_one_whatever_its_map(tmp_path: Path, factor: float, unit: str) -> None:
    """A commanded speed whose map is wrong by half is still in m/s: that is for a diagnosis to find."""
    assert logged(tmp_path, STEER, factor * SPEED).spec.columns["speed"].unit == unit


@pytest.mark.parametrize(("factor", "unit"), [(1.0, ""), (100.0, "cm/s")])
def test_a_velocity_to_the_side_that_is_always_zero_says_nothing_of_the_unit(
    tmp_path: Path, factor: float, unit: str
) -> None:
    found = logged(tmp_path, STEER, SPEED, twist_vx=factor * SPEED, twist_vy=np.zeros(len(TIME)))
    assert (found.spec.velocity_frame, found.spec.columns["vx"].unit) == ("body", unit)
    evidence = next(row.evidence for row in found.rows if row.column == "twist_vx")
    assert float(re.findall(r"moves (\S+) times", evidence)[0]) == pytest.approx(factor, rel=0.1)


@pytest.mark.parametrize(("factor", "confidence"), [(1.0, "guess"), (180.0 / np.pi, "certain")])
def test_a_heading_of_more_than_a_turn_may_be_in_either_unit_where_its_rate_is_small(
    tmp_path: Path, factor: float, confidence: str
) -> None:
    """Of a robot that drives where it does not point: nothing but sizes tells, and 10 of a slow ship are degrees."""
    yaw, side = 1.4 * TIME + np.sin(TIME), np.random.default_rng(2).normal(0.0, 0.02, len(TIME)).cumsum()
    columns = {"t": TIME, "x": np.sin(0.7 * TIME), "y": side, "yaw": factor * yaw, "wz": factor * (1.4 + np.cos(TIME))}
    (row,) = (row for row in inspect_logs(saved(tmp_path, columns, "omni.csv")).rows if row.column == "yaw")
    assert (row.unit, row.confidence) == ("deg", confidence)
    assert ("or rad" in row.evidence) == (confidence == "guess")


@pytest.mark.parametrize("letters", ["wz", "zw"])
def test_a_quaternion_of_the_components_that_a_robot_on_the_ground_has_is_its_heading(
    tmp_path: Path, letters: str
) -> None:
    parts = {"w": np.cos(YAW / 2), "z": np.sin(YAW / 2)}
    columns = drive(steer=STEER, speed=SPEED, **{f"orientation.{letter}": parts[letter] for letter in letters})
    found = inspect_logs(saved(tmp_path, columns, "car.csv"))
    read = read_log(tmp_path / "car.csv", LogSpec.parse(found.toml()), layouts=ROBOTS["mushr"].layouts)
    turned = np.angle(np.exp(1j * (np.arctan2(read.column("sin_yaw"), read.column("cos_yaw")) - YAW[: len(read)])))
    assert np.abs(turned).max() < 1e-6


@pytest.mark.parametrize(("sine", "cosine"), [("yaw_sin", "yaw_cos"), ("sinPsi", "cosPsi"), ("heading_sine", "cosine")])
def test_sine_and_cosine_of_a_heading_are_no_heading(tmp_path: Path, sine: str, cosine: str) -> None:
    found = inspect_logs(saved(tmp_path, drive(steer=STEER, **{sine: np.sin(YAW), cosine: np.cos(YAW)})))
    assert not {"yaw", "ref_yaw"} & found.spec.columns.keys()
    assert {"x", "y", "steer"} <= found.spec.columns.keys()


def test_an_acceleration_ahead_alone_is_a_cars_command(tmp_path: Path) -> None:
    ahead = np.gradient(SPEED, TIME)
    columns = drive(yaw=YAW, road_wheel_deg=np.degrees(STEER), ax_request=ahead)
    assert {"steer", "acceleration"} <= inspect_logs(saved(tmp_path, columns)).spec.columns.keys()
    planned = columns | {"speed_cmd": SPEED}
    assert "acceleration" not in inspect_logs(saved(tmp_path, planned)).spec.columns


def test_a_log_of_what_stays_on_the_ground_lacks_what_a_car_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["inspect", str(saved(tmp_path, drive(yaw=YAW)))])
    assert "it lacks speed, steer in a known unit" in " ".join(capsys.readouterr().out.split())


def test_a_log_of_a_car_whose_commands_are_counts_is_a_cars(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    covariances = {f"pose.covariance[{place}]": np.zeros(len(TIME)) for place in range(36)}
    logged(tmp_path, CENTRE + TRAVEL * STEER, MOST_TURNS * SPEED, **covariances)
    main(["inspect", str(tmp_path / "car.csv"), "--out", str(tmp_path / "car.toml")])
    said = " ".join(capsys.readouterr().out.split())
    assert "it lacks speed, steer in a known unit" in said
    assert "(36 columns)" in said
    assert "covariance[17]" not in said


@pytest.mark.parametrize(("per_rad", "unit"), [(1.0, ""), (180.0 / np.pi, "deg")])
def test_a_heading_without_steering_turns_with_the_path_in_one_unit(per_rad: float, unit: str, tmp_path: Path) -> None:
    """Wheels of a rover: whoever counts on beyond a turn in rad is not in degrees, whatever the size says."""
    time = 0.04 * np.arange(400)
    yaw = 0.8 * time + 0.5 * np.sin(1.3 * time)
    speed = 0.6 + 0.2 * np.sin(0.7 * time)
    way = np.cumsum(speed * np.array([np.cos(yaw), np.sin(yaw)]) * 0.04, axis=1)
    columns = {"t": time, "x": way[0], "y": way[1], "yaw": per_rad * yaw, "left": 20.0 * speed, "right": 21.0 * speed}
    found = inspect_logs(saved(tmp_path, columns, "rover.csv"))
    assert found.spec.columns["yaw"].unit == unit
    assert not found.suspected_flips
