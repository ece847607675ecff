"""Inspection of logs made from rigid-body kinematics, in the units, orders, frames and names that people use.

Every flight is exact: positions are sums of sines, the thrust axis is the direction of acceleration minus gravity,
body rates are those of the attitude. What the inspection proposes is used to read the log, and must give it back.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
from numpy.typing import NDArray

from sym2real import rotation
from sym2real.errors import DataError
from sym2real.logs import LogSpec, inspect_logs, read_log
from sym2real.logs.parts import TimeBase
from sym2real.logs.units import UNITS

Array = NDArray[np.float64]
GRAVITY = 9.80665
ROWS = 700
STEP = 0.01


@dataclass(frozen=True)
class Flight:
    time: Array
    position: Array
    velocity: Array
    quaternion: Array
    rate: Array
    thrust: Array  # m/s²


def attitude(time: Array) -> tuple[Array, Array, Array, Array]:
    amplitude, speed = np.array([1.0, 0.8, 0.3]), np.array([1.3, 1.9, 0.9])
    phase = np.outer(time, speed) + np.array([0.0, 0.7, 0.3])
    position = amplitude * np.sin(phase) + [0.0, 0.0, 1.2]
    velocity = amplitude * speed * np.cos(phase)
    push = -amplitude * speed**2 * np.sin(phase) + [0.0, 0.0, GRAVITY]
    yaw = 0.9 * time + 0.4 * np.sin(1.1 * time)
    up = push / np.linalg.norm(push, axis=1, keepdims=True)
    ahead = np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], axis=1)
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    matrix = np.stack([np.cross(left, up), left, up], axis=2)
    w = 0.5 * np.sqrt(np.maximum(1e-9, 1 + np.trace(matrix, axis1=1, axis2=2)))
    # The way by angles avoids the singularity of the trace formula at half turns.
    roll = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])
    pitch = -np.arcsin(matrix[:, 2, 0])
    heading = np.unwrap(np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0]))
    quaternion = rotation.from_euler(*(torch.from_numpy(angle) for angle in (roll, pitch, heading))).numpy()
    assert np.allclose(np.abs(quaternion[:, 0]), w, atol=1e-4)
    return position, velocity, quaternion, np.linalg.norm(push, axis=1)


@pytest.fixture(scope="module")
def flight() -> Flight:
    time = STEP * np.arange(ROWS)
    small = 1e-5
    position, velocity, quaternion, thrust = attitude(time)
    before, after = (torch.from_numpy(attitude(time + shift)[2]) for shift in (-small, small))
    turn = rotation.logarithm(rotation.multiply(rotation.conjugate(before), after))
    noise = np.random.default_rng(3)
    return Flight(
        time,
        position + noise.normal(0, 2e-4, position.shape),
        velocity + noise.normal(0, 5e-3, velocity.shape),
        quaternion,
        turn.numpy() / (2 * small) + noise.normal(0, 0.02, (ROWS, 3)),
        thrust,
    )


def angles(quaternion: Array) -> Array:
    matrix = rotation.to_matrix(torch.from_numpy(quaternion)).numpy()
    roll = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])
    return np.stack([roll, -np.arcsin(matrix[:, 2, 0]), np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])], axis=1)


def named(names: str, values: Array) -> dict[str, Array]:
    return dict(zip(names.split(), values.T, strict=True))


def cflib(flight: Flight) -> dict[str, Array]:
    """Crazyflie client: degrees, ms, 16-bit motors, and the legacy sign of pitch."""
    euler = np.degrees(angles(flight.quaternion)) * [1, -1, 1]
    motors = np.round(np.outer(flight.thrust / GRAVITY, [41000, 40000, 42000, 40500]))
    return {
        "timestamp": 1e3 * flight.time + 91234.0,
        **named("stateEstimate.x stateEstimate.y stateEstimate.z", flight.position),
        **named("stateEstimate.vx stateEstimate.vy stateEstimate.vz", flight.velocity),
        **named("stabilizer.roll stabilizer.pitch stabilizer.yaw", euler),
        **named("gyro.x gyro.y gyro.z", np.degrees(flight.rate)),
        **named("motor.m1 motor.m2 motor.m3 motor.m4", motors),
        "pm.vbatMV": 3700 - 10 * flight.time,
    }


def px4(flight: Flight) -> dict[str, Array]:
    """PX4: µs, north-east-down, forward-right-down, scalar first."""
    turned = np.array([1.0, -1.0, -1.0])
    return {
        "timestamp": np.round(1e6 * flight.time) + 5e8,
        **named("vehicle_local_position.x vehicle_local_position.y vehicle_local_position.z", flight.position * turned),
        **named(
            "vehicle_local_position.vx vehicle_local_position.vy vehicle_local_position.vz", flight.velocity * turned
        ),
        **named(
            "vehicle_attitude.q[0] vehicle_attitude.q[1] vehicle_attitude.q[2] vehicle_attitude.q[3]",
            flight.quaternion * [1, 1, -1, -1],
        ),
        **named(
            "vehicle_angular_velocity.xyz[0] vehicle_angular_velocity.xyz[1] vehicle_angular_velocity.xyz[2]",
            flight.rate * turned,
        ),
    }


def ros(flight: Flight) -> dict[str, Array]:
    """ROS odometry: ns, scalar last by name, the twist in body axes."""
    inverse = rotation.conjugate(torch.from_numpy(flight.quaternion))
    body = rotation.rotate(inverse, torch.from_numpy(flight.velocity)).numpy()
    return {
        "%time": np.round(1e9 * flight.time) + 1.7e18,
        **named(".pose.pose.position.x .pose.pose.position.y .pose.pose.position.z", flight.position),
        **named(
            ".pose.pose.orientation.x .pose.pose.orientation.y .pose.pose.orientation.z .pose.pose.orientation.w",
            np.roll(flight.quaternion, -1, axis=1),
        ),
        **named(".twist.twist.linear.x .twist.twist.linear.y .twist.twist.linear.z", body),
        **named(".twist.twist.angular.x .twist.twist.angular.y .twist.twist.angular.z", flight.rate),
    }


def numbered(flight: Flight) -> dict[str, Array]:
    """Counted quaternion components, scalar last; mm; gyro in deg/s with x reversed; no velocity."""
    return {
        "time_us": 1e6 * flight.time,
        **named("pos_x pos_y pos_z", 1e3 * flight.position),
        **named("q0 q1 q2 q3", np.roll(flight.quaternion, -1, axis=1)),
        **named("gyro_x gyro_y gyro_z", np.degrees(flight.rate) * [-1, 1, 1]),
        "thrust": flight.thrust,
    }


def inverse_attitude(flight: Flight) -> dict[str, Array]:
    """A quaternion that turns world vectors into the body; thrust in N of 35 g; rate commands 50 ms ahead."""
    return {
        "t": flight.time,
        **named("x y z", flight.position),
        **named("vx vy vz", flight.velocity),
        **named("qw qx qy qz", flight.quaternion * [1, -1, -1, -1]),
        **named("p q r", flight.rate),
        "thrust_cmd": 0.035 * flight.thrust,
        **named("p_cmd q_cmd r_cmd", np.roll(flight.rate, -5, axis=0)),
    }


def save(folder: Path, columns: dict[str, Array]) -> Path:
    path = folder / "log.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def check(flight: Flight, path: Path, spec: LogSpec, position: float = 1e-3, velocity: float = 0.03) -> None:
    """What a specification reads is the flight: positions, velocities, attitudes, rates, up to the sign of q."""
    log = read_log(path, spec)
    rows = len(log)
    assert rows >= ROWS - 2
    read = {field.name: log.state[:, log.layouts.state.slice(field.name)] for field in log.layouts.state.fields}
    assert np.allclose(log.time, flight.time[:rows], atol=1e-6)
    assert np.allclose(read["position"], flight.position[:rows], atol=position)
    inside = slice(3, rows - 3)
    assert np.allclose(read["velocity"][inside], flight.velocity[:rows][inside], atol=velocity)
    aligned = np.abs(np.sum(read["attitude"] * flight.quaternion[:rows], axis=1))
    assert np.allclose(aligned, 1.0, atol=1e-6)
    assert np.allclose(read["rate"], flight.rate[:rows], atol=1e-3)


def test_client_log_in_degrees_with_the_legacy_pitch(flight: Flight, tmp_path: Path) -> None:
    path = save(tmp_path, cflib(flight))
    found = inspect_logs(path)
    assert found.spec.time.unit == "ms"
    assert found.spec.attitude.unit == "deg"
    assert found.spec.columns["wx"].unit == "deg/s"
    assert found.spec.columns["motor3"].unit == "uint16"
    assert found.spec.columns["vbat"].unit == "mV"
    # The acceleration sides with the gyro: it is the angle that is reversed, not gyro.y.
    assert found.suspected_flips == ("stabilizer.pitch",)
    assert found.spec.flip == ()
    accepted = LogSpec.parse(found.toml().replace("# flip", "flip"))
    check(flight, path, accepted)


def test_px4_log_is_north_east_down(flight: Flight, tmp_path: Path) -> None:
    path = save(tmp_path, px4(flight))
    found = inspect_logs(path)
    assert found.spec.time.unit == "us"
    assert found.spec.frames == "ned_frd"
    assert found.suspected_flips == ()
    check(flight, path, found.spec)


def test_rates_by_aeronautics_letters_and_a_thrust_along_z_down(flight: Flight, tmp_path: Path) -> None:
    columns = {name: values for name, values in px4(flight).items() if "angular" not in name}
    turned = flight.rate * [1.0, -1.0, -1.0]
    columns |= named("gyro_p gyro_q gyro_r", turned) | named("rate_sp_p rate_sp_q rate_sp_r", turned)
    columns["thrust_sp_z"] = -0.05 * flight.thrust
    path = save(tmp_path, columns)
    found = inspect_logs(path)
    assert [found.spec.columns[name].column for name in ("wx", "wz", "wy_cmd")] == ["gyro_p", "gyro_r", "rate_sp_q"]
    check(flight, path, found.spec)
    assert found.spec.flip == ("thrust_sp_z",)  # in such frames minus z is up
    scale = float(re.findall(r"mass in kg × (\S+)", found.toml())[0])
    read = read_log(path, LogSpec.parse(found.toml())).column("thrust")
    assert scale * read.mean() == pytest.approx(GRAVITY, rel=1e-3)


@pytest.mark.parametrize("gyro", ["gx_dps gy_dps gz_dps", "gx gy gz", "imu_gx imu_gy imu_gz"])
def test_velocities_are_u_v_w_and_a_gyro_is_g(flight: Flight, tmp_path: Path, gyro: str) -> None:
    body = {".twist.twist.linear.x": "u", ".twist.twist.linear.y": "v", ".twist.twist.linear.z": "w"}
    columns = {body.get(name, name): values for name, values in ros(flight).items() if "angular" not in name}
    path = save(tmp_path, columns | named(gyro, np.degrees(flight.rate)))
    found = inspect_logs(path)
    assert found.spec.velocity_frame == "body"
    assert [found.spec.columns[name].column for name in ("vx", "vy", "vz", "wy")] == ["u", "v", "w", gyro.split()[1]]
    check(flight, path, found.spec)


def test_a_column_that_is_called_x_is_the_place_before_one_that_may_be(flight: Flight, tmp_path: Path) -> None:
    """As ``ulog2csv`` writes PX4's topics, a file each: topics are gone, and rates are xyz[0] to xyz[2]."""
    columns = {name.rpartition(".")[2]: values for name, values in px4(flight).items()}
    path = save(tmp_path, dict(sorted(columns.items(), key=lambda column: not column[0].startswith("xyz"))))
    found = inspect_logs(path)
    assert [found.spec.columns[axis].column for axis in ("x", "y", "z", "vx")] == ["x", "y", "z", "vx"]
    assert {found.spec.columns[axis].unit for axis in "xyz"} == {""}
    assert found.spec.frames == "ned_frd"
    assert found.spec.columns["wy"].column == "xyz[1]"
    check(flight, path, found.spec)


@pytest.mark.parametrize("what", ["rates", "angles"])
def test_roll_pitch_and_yaw_beside_a_quaternion_are_rate_commands_where_rates_follow(
    flight: Flight, tmp_path: Path, what: str
) -> None:
    """PX4's ``vehicle_rates_setpoint`` has these names; other loggers write the angles once more."""
    columns = {name.rpartition(".")[2]: values for name, values in px4(flight).items()}
    turned = {"rates": flight.rate, "angles": angles(flight.quaternion)}[what] * [1.0, -1.0, -1.0]
    found = inspect_logs(save(tmp_path, columns | named("roll pitch yaw", turned)))
    commands = {name: source.column for name, source in found.spec.columns.items() if name.endswith("_cmd")}
    assert commands == ({"wx_cmd": "roll", "wy_cmd": "pitch", "wz_cmd": "yaw"} if what == "rates" else {})


def test_a_rotation_of_four_parts_is_a_quaternion(flight: Flight, tmp_path: Path) -> None:
    """Three of them are a vector of angles, beside Vicon's TX to TZ."""
    rotation_of = dict(zip(("RW", "RX", "RY", "RZ"), flight.quaternion.T, strict=True))
    columns = {"t": flight.time, **named("TX TY TZ", flight.position), **rotation_of, **named("wx wy wz", flight.rate)}
    found = inspect_logs(save(tmp_path, columns))
    assert found.spec.attitude.quaternion == ("RW", "RX", "RY", "RZ")


def test_a_log_that_names_the_compass_is_north_east_down(flight: Flight, tmp_path: Path) -> None:
    columns = px4(flight)
    words = {".x": "north", ".y": "east", ".z": "down", ".vx": "v_n", ".vy": "v_e", ".vz": "v_d"}
    names = {f"vehicle_local_position{end}": word for end, word in words.items()}
    path = save(tmp_path, {names.get(name, name): values for name, values in columns.items()})
    found = inspect_logs(path)
    assert found.spec.frames == "ned_frd"
    assert [found.spec.columns[axis].column for axis in ("x", "vz")] == ["north", "v_d"]
    check(flight, path, found.spec)


def test_ros_log_has_body_velocities(flight: Flight, tmp_path: Path) -> None:
    path = save(tmp_path, ros(flight))
    found = inspect_logs(path)
    assert found.spec.time.unit == "ns"
    assert found.spec.velocity_frame == "body"
    assert found.spec.attitude.order == "wxyz"
    assert found.suspected_flips == ()
    check(flight, path, found.spec)


def test_numbered_quaternion_is_scalar_last(flight: Flight, tmp_path: Path) -> None:
    path = save(tmp_path, numbered(flight))
    found = inspect_logs(path)
    assert found.spec.attitude.order == "xyzw"
    assert found.spec.columns["x"].unit == "mm"
    assert found.spec.columns["wz"].unit == "deg/s"
    assert found.spec.columns["thrust"].unit == "m/s^2"
    assert found.spec.derive == ("velocity",)
    assert found.suspected_flips == ("gyro_x",)
    assert "correlation -" in next(line for line in found.toml().splitlines() if "suspected: gyro_x" in line)
    check(flight, path, LogSpec.parse(found.toml().replace("# flip", "flip")), velocity=0.1)


def test_one_axis_may_be_in_another_unit_than_the_others(flight: Flight, tmp_path: Path) -> None:
    columns = {"t": flight.time, **named("qw qx qy qz", flight.quaternion), **named("vx vy vz", flight.velocity)}
    columns |= named("x y z", flight.position * [1.0, 1.0, 1e3]) | named("wx wy wz", flight.rate)
    path = save(tmp_path, columns)
    found = inspect_logs(path).spec
    assert [found.columns[axis].unit for axis in "xyz"] == ["", "", "mm"]
    check(flight, path, found)


@pytest.mark.parametrize("prefix", ["t", "vicon.t"])
def test_translations_by_their_letter_as_trajectories_of_tum_have_them(
    flight: Flight, tmp_path: Path, prefix: str
) -> None:
    columns = {key.replace(".pose.pose.position.", prefix): values for key, values in ros(flight).items()}
    path = save(tmp_path, columns)
    found = inspect_logs(path)
    assert [found.spec.columns[axis].column for axis in "xyz"] == [f"{prefix}{axis}" for axis in "xyz"]
    check(flight, path, found.spec)


def test_inverse_attitude_and_commands(flight: Flight, tmp_path: Path) -> None:
    path = save(tmp_path, inverse_attitude(flight))
    found = inspect_logs(path)
    assert found.spec.attitude.direction == "world_to_body"
    assert found.suspected_flips == ()
    check(flight, path, found.spec)
    mass = next(row for row in found.rows if row.column == "thrust_cmd")
    assert "0.035 kg" in mass.evidence


@pytest.mark.parametrize(("make", "places"), [(px4, "vehicle_local_position."), (ros, ".pose.pose.position.")])
def test_noise_of_positions_makes_no_robot_lighter(
    flight: Flight, tmp_path: Path, make: Callable[[Flight], dict[str, Array]], places: str
) -> None:
    """Of 3 cm at 50 Hz each row's acceleration is off by 30 m/s², with z up or down; the mean carries the weight."""
    noise = np.random.default_rng(5)
    columns = {
        name: (values + noise.normal(0.0, 0.03, ROWS) * name.startswith(places))[::2]
        for name, values in (make(flight) | {"thrust": 1.5 * flight.thrust}).items()
    }
    found = next(row for row in inspect_logs(save(tmp_path, columns)).rows if row.column == "thrust")
    share = float(re.findall(r"(\S+) times the specific force", found.evidence)[0])
    assert share == pytest.approx(1.5, rel=0.06)


@pytest.mark.parametrize("make", [cflib, px4, ros, numbered, inverse_attitude])
def test_proposals_read_back_as_toml(
    flight: Flight, tmp_path: Path, make: Callable[[Flight], dict[str, Array]]
) -> None:
    found = inspect_logs(save(tmp_path, make(flight)))
    assert LogSpec.parse(found.toml()) == found.spec
    assert {row.column for row in found.rows} >= {name.lstrip("%") for name in make(flight)}


def test_without_stamps_no_log_is_read_until_the_rows_a_second_are_filled_in(tmp_path: Path) -> None:
    """Any number would pass for a rate, and every slope and delay of the answer would be off by it."""
    file = save(tmp_path, {"x": np.arange(50.0), "y": np.zeros(50)})
    found = inspect_logs(file)
    assert found.waiting
    with pytest.raises(DataError, match=r"time\.rate to be a number > 0"):
        LogSpec.parse(found.toml())
    with pytest.raises(DataError, match="the rows a second, which a log without stamps does not say"):
        read_log(file, found.spec)
    filled = LogSpec.parse(found.toml().replace("rate = 0.0", "rate = 50"))
    assert read_log(file, filled).time[1] == pytest.approx(0.02)


def test_a_thrust_that_is_never_given_carries_nothing(tmp_path: Path) -> None:
    time = STEP * np.arange(ROWS)
    cells = np.stack([time, 0.1 * time, np.zeros(ROWS)], axis=1)
    np.savetxt(tmp_path / "log.csv", cells, delimiter=",", header="t,z,thrust", comments="")
    found = inspect_logs(tmp_path / "log.csv")
    assert "thrust" not in found.spec.columns
    assert any(row.column == "thrust" and "carries nothing" in row.evidence for row in found.rows)


@pytest.mark.parametrize(("name", "unit"), [("ms", "ms"), ("Micros", "us"), ("millis", "ms"), ("nsec", "ns")])
def test_a_column_called_by_a_unit_of_time_holds_stamps(name: str, unit: str, tmp_path: Path) -> None:
    step = 0.02 / UNITS[unit][1]
    file = save(tmp_path, {name: step * np.arange(50), "x": np.arange(50.0)})
    assert inspect_logs(file).spec.time == TimeBase(name, unit, dt=0.02)


@pytest.mark.parametrize(
    ("name", "values", "stamps"), [("gps_us", 2e4, True), ("Zeit [us]", 2e4, True), ("ahead_s", 0.02, False)]
)
def test_what_ticks_in_a_unit_of_time_holds_stamps_where_nothing_is_called_so(
    name: str, values: float, stamps: bool, tmp_path: Path
) -> None:
    """Stamps of a receiver; a way along a path goes up as evenly."""
    ticks = values * (50.0 + np.arange(200) + 0.1 * np.sin(np.arange(200)))
    moving = np.sin(0.1 * np.arange(200))
    found = inspect_logs(save(tmp_path, {name: ticks, "x": moving, "y": moving**2}))
    assert found.spec.time == (TimeBase(name, "us", dt=0.02) if stamps else found.spec.time)
    assert (found.spec.time.column == name) == stamps


@pytest.mark.parametrize("written", ["dates", "ns"])
def test_a_clock_that_counts_from_1970_needs_no_name(written: str, tmp_path: Path) -> None:
    start = datetime(2026, 3, 1, 10, tzinfo=UTC)
    times = [start + timedelta(milliseconds=20 * row) for row in range(60)]
    dates = [time.isoformat() for time in times]
    counts = [10**9 * int(time.timestamp()) + 10**3 * time.microsecond for time in times]
    cells, unit = (dates, "s") if written == "dates" else (counts, "ns")
    lines = [f"{cell},{np.sin(0.1 * row):.6f},{1e10 + row**2}" for row, cell in enumerate(cells)]
    (tmp_path / "log.csv").write_text("\n".join(["Zeit,x,odd", *lines]))
    assert inspect_logs(tmp_path / "log.csv").spec.time == TimeBase("Zeit", unit, dt=0.02)


@pytest.mark.parametrize("odd", [0, 2])
def test_a_log_in_another_unit_than_the_others_is_named_and_decides_nothing(
    odd: int, flight: Flight, tmp_path: Path
) -> None:
    """One gyro in deg/s among four made all of them be read so."""
    columns = {"t": flight.time, **named("x y z", flight.position), **named("qw qx qy qz", flight.quaternion)}
    for number in range(4):
        scale = np.degrees(1.0) if number == odd else 1.0
        save(tmp_path, columns | named("wx wy wz", scale * flight.rate)).rename(tmp_path / f"{number}.csv")
    found = inspect_logs(tmp_path)
    assert [found.spec.columns[rate].unit for rate in ("wx", "wy", "wz")] == ["", "", ""]
    alone = [row for row in found.rows if f"in {odd}.csv alone" in row.evidence]
    assert [(row.meaning, row.unit) for row in alone] == [("wx", "deg/s"), ("wy", "deg/s"), ("wz", "deg/s")]
    (tmp_path / f"{odd}.csv").unlink()
    assert not any("alone" in row.evidence for row in inspect_logs(tmp_path).rows)
