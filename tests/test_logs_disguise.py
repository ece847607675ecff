"""The project's own real flight in disguise, and cars and odd logs: what inspection must see through."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
from kinematic_car import car

from sym2real import rotation
from sym2real.data import example_flight
from sym2real.errors import DataError
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_log
from sym2real.logs.assignment import assign
from sym2real.logs.names import read_name
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array, Trajectory

Disguise = Callable[[pd.DataFrame], pd.DataFrame]
POSITION, QUATERNION, VELOCITY, RATE = (
    ["px", "py", "pz"], ["qw", "qx", "qy", "qz"], ["vx", "vy", "vz"], ["wx", "wy", "wz"],
)  # fmt: skip
DOWN = np.array([1.0, -1.0, -1.0])


def renamed(log: pd.DataFrame, old: list[str], new: list[str], values: Array | None = None) -> pd.DataFrame:
    values = log[old].to_numpy() if values is None else values
    return log.drop(columns=old).assign(**dict(zip(new, values.T, strict=True)))


def euler_degrees(log: pd.DataFrame) -> Array:
    quaternion = rotation.normalise(torch.tensor(log[QUATERNION].to_numpy()))
    matrix = rotation.to_matrix(quaternion).numpy()
    roll, yaw = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2]), np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])
    return np.degrees(np.stack([roll, -np.arcsin(matrix[:, 2, 0]), yaw], axis=1))


def xyzw(log: pd.DataFrame) -> pd.DataFrame:
    return renamed(log, QUATERNION, [f"quat[{i}]" for i in range(4)], np.roll(log[QUATERNION].to_numpy(), -1, axis=1))


def xyzw_by_other_names(log: pd.DataFrame) -> pd.DataFrame:
    log[QUATERNION] = np.roll(log[QUATERNION].to_numpy(), -1, axis=1)
    return log


def wxyz(log: pd.DataFrame) -> pd.DataFrame:
    return renamed(log, QUATERNION, [f"q_{i}" for i in range(1, 5)])


def degrees(log: pd.DataFrame) -> pd.DataFrame:
    log = renamed(log, QUATERNION, ["roll", "pitch", "yaw"], euler_degrees(log))
    return renamed(log, RATE, ["gyro.x", "gyro.y", "gyro.z"], np.degrees(log[RATE].to_numpy()))


def radians(log: pd.DataFrame) -> pd.DataFrame:
    return renamed(log, QUATERNION, ["phi", "theta", "psi"], np.radians(euler_degrees(log)))


def legacy_pitch(log: pd.DataFrame) -> pd.DataFrame:
    return degrees(log).assign(pitch=lambda frame: -frame["pitch"])


def ned(log: pd.DataFrame) -> pd.DataFrame:
    for columns in (POSITION, VELOCITY, RATE):
        log[columns] *= DOWN
    log[QUATERNION] *= np.array([1.0, 1.0, -1.0, -1.0])
    return log.assign(ref_py=-log["ref_py"], ref_pz=-log["ref_pz"])


def inverse(log: pd.DataFrame) -> pd.DataFrame:
    log[QUATERNION] *= np.array([1.0, -1.0, -1.0, -1.0])
    return log


def body_velocity(log: pd.DataFrame) -> pd.DataFrame:
    attitude = rotation.conjugate(rotation.normalise(torch.tensor(log[QUATERNION].to_numpy())))
    log[VELOCITY] = rotation.rotate(attitude, torch.tensor(log[VELOCITY].to_numpy())).numpy()
    return log


def millimetres(log: pd.DataFrame) -> pd.DataFrame:
    log[POSITION] *= 1e3
    return log


def only_millimetres(log: pd.DataFrame) -> pd.DataFrame:
    return millimetres(log).drop(columns=VELOCITY)


def microseconds(log: pd.DataFrame) -> pd.DataFrame:
    return log.assign(timestamp=np.round(log["t"] * 1e6) + 7e9).drop(columns="t")


def sixteen_bits(log: pd.DataFrame) -> pd.DataFrame:
    motors = [f"motor{i}_cmd" for i in range(1, 5)]
    return renamed(log, motors, [f"motor.m{i}" for i in range(1, 5)], np.round(log[motors].to_numpy() * 65535))


def reversed_gyro(*columns: str) -> Disguise:
    def apply(log: pd.DataFrame) -> pd.DataFrame:
        log[list(columns)] *= -1.0
        return log

    return apply


CASES: dict[str, tuple[Disguise, tuple[str, ...]]] = {
    "xyzw": (xyzw, ()),
    "xyzw in columns of wxyz": (xyzw_by_other_names, ()),
    "wxyz": (wxyz, ()),
    "degrees": (degrees, ()),
    "radians": (radians, ()),
    "legacy pitch": (legacy_pitch, ("pitch",)),
    "north-east-down": (ned, ()),
    "inverse": (inverse, ()),
    "body velocity": (body_velocity, ()),
    "mm": (millimetres, ()),
    "mm without velocity": (only_millimetres, ()),
    "us": (microseconds, ()),
    "16 bits": (sixteen_bits, ()),
    "gyro x": (reversed_gyro("wx"), ("wx",)),
    "gyro y": (reversed_gyro("wy"), ("wy",)),
    "gyro x z": (reversed_gyro("wx", "wz"), ("wx", "wz")),
    "velocity y": (reversed_gyro("vy"), ("vy",)),
}


@pytest.fixture(scope="module")
def flight() -> Trajectory:
    return read_log(example_flight(), "crazyflie_battery_drag")


@pytest.mark.parametrize("case", CASES)
def test_a_disguised_flight_is_recognised(tmp_path: Path, flight: Trajectory, case: str) -> None:
    disguise, flips = CASES[case]
    path = tmp_path / "log.csv"
    disguise(pd.read_csv(example_flight())).to_csv(path, index=False)
    found = inspect_logs(path)
    assert set(found.suspected_flips) == set(flips)
    accepted = LogSpec.parse(found.toml().replace("# flip", "flip"))
    log = read_log(path, accepted, flight.layouts)
    for field in flight.layouts.state.fields:
        columns = flight.layouts.state.slice(field.name)
        error = flight.layouts.state.normalise(torch.tensor(log.state))[:, columns].numpy() - flight.state[:, columns]
        assert np.sqrt(np.mean(error**2)) < {"position": 1e-6, "attitude": 1e-5}.get(field.name, 5e-3), field.name
    assert np.allclose(log.action, flight.action, atol=1e-5)


def test_a_car_in_degrees_with_body_velocity_and_no_yaw_rate(tmp_path: Path) -> None:
    time, position, yaw, speed, steer = car()
    wrapped = np.degrees((yaw + np.pi) % (2 * np.pi) - np.pi)
    columns = {
        "Time[ms]": 1e3 * time, "x": position[:, 0], "y": position[:, 1], "theta": wrapped,
        "vel_x": speed, "vel_y": 0 * time, "steering_angle_deg": np.degrees(steer), "cmd_speed": speed,
    }  # fmt: skip
    pd.DataFrame(columns).to_csv(tmp_path / "car.csv", index=False)
    found = inspect_logs(tmp_path / "car.csv")
    assert found.spec.time.unit == "ms"
    assert {name: source.unit for name, source in found.spec.columns.items() if source.unit} == {
        "yaw": "deg", "steer": "deg",
    }  # fmt: skip
    assert found.spec.derive == ("rate",)
    assert found.spec.velocity_frame == "body"
    log = read_log(tmp_path / "car.csv", found.spec)
    assert log.layouts.state.columns == ("x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz")
    assert np.allclose(np.unwrap(np.arctan2(log.column("sin_yaw"), log.column("cos_yaw"))), yaw, atol=1e-9)
    assert np.allclose(log.column("vx"), speed * np.cos(yaw), atol=1e-9)
    assert np.allclose(log.column("steer"), steer, atol=1e-12)


@pytest.mark.parametrize(("turn", "gyro"), [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_a_car_with_a_quaternion(tmp_path: Path, turn: float, gyro: float) -> None:
    """An inverse rotation and a reversed gyro look alike but for the way the car drives."""
    time, position, yaw, speed, steer = car()
    columns = {
        "t": time, "x": position[:, 0], "y": position[:, 1],
        "qx": 0 * yaw, "qy": 0 * yaw, "qz": turn * np.sin(yaw / 2), "qw": np.cos(yaw / 2),
        "gyro_z": gyro * np.gradient(yaw, time), "steer": steer, "speed": speed,
    }  # fmt: skip
    pd.DataFrame(columns).to_csv(tmp_path / "car.csv", index=False)
    found = inspect_logs(tmp_path / "car.csv")
    assert found.spec.attitude.direction == ("world_to_body" if turn < 0 else "body_to_world")
    assert found.suspected_flips == (("gyro_z",) if gyro < 0 else ())
    layouts = Layouts(Layout.of(["x", "y", "sin_yaw", "cos_yaw"]), Layout.of(["steer", "speed"]))
    log = read_log(tmp_path / "car.csv", found.spec, layouts)
    assert np.allclose(log.column("sin_yaw"), np.sin(yaw), atol=1e-9)


def test_stamps_that_stand_are_refused(tmp_path: Path) -> None:
    log = pd.read_csv(example_flight())
    log.loc[40, "t"] = log.loc[39, "t"]
    log.to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(DataError, match=r"row 42, column 't'.*the same stamp again"):
        inspect_logs(tmp_path / "log.csv")


def test_a_car_is_read_by_usual_names(tmp_path: Path) -> None:
    time, position, yaw, speed, steer = car()
    columns = {
        "t": time, "x": position[:, 0], "y": position[:, 1], "yaw": yaw, "yaw_rate": np.gradient(yaw, time),
        "steer": steer, "speed": speed,
    }  # fmt: skip
    pd.DataFrame(columns).to_csv(tmp_path / "car.csv", index=False)
    found = inspect_logs(tmp_path / "car.csv")
    assert {"steer", "speed", "yaw", "wz"} <= found.spec.columns.keys()


def test_pulses_of_a_servo_are_left_to_the_user(tmp_path: Path) -> None:
    time, position, yaw, speed, steer = car()
    columns = {
        "t": time, "x": position[:, 0], "y": position[:, 1], "heading_deg": np.degrees(yaw),
        "servo_us": np.round(1500 + 1000 * steer), "speed_setpoint": speed,
    }  # fmt: skip
    pd.DataFrame(columns).to_csv(tmp_path / "car.csv", index=False)
    found = inspect_logs(tmp_path / "car.csv")
    assert "steer" not in found.spec.columns
    line = next(line for line in found.toml().splitlines() if line.startswith("# steer ="))
    text = found.toml().replace(line, line[2:])
    accepted = read_log(tmp_path / "car.csv", LogSpec.parse(text))
    assert np.allclose(accepted.column("steer"), steer, atol=5.1e-4)


def test_compass_names_of_any_case() -> None:
    named = {"x": "XKF1.PN", "y": "XKF1.PE", "z": "XKF1.PD", "vx": "XKF1.VN", "vy": "XKF1.VE", "vz": "XKF1.VD"}
    assert assign([*named.values()]).columns == named  # ArduPilot's


def test_compass_names() -> None:
    assert assign(["v_n", "v_e", "v_d"]).columns == {"vx": "v_n", "vy": "v_e", "vz": "v_d"}
    assert assign(["east_m", "north_m", "up_m"]).columns == {"x": "east_m", "y": "north_m", "z": "up_m"}
    assert assign(["east", "north", "heading"]).columns == {"x": "east", "y": "north", "yaw": "heading"}
    assert assign(["East [m]", "North [m]"]).columns == {"x": "East [m]", "y": "North [m]"}
    assert assign(["utm_n", "utm_e"]).columns == {"x": "utm_e", "y": "utm_n"}
    assert assign(["pos_e", "pos_n", "pos_d"]).columns == {"x": "pos_n", "y": "pos_e", "z": "pos_d"}
    assert assign(["port_n", "easting", "northing", "hdg"]).columns == {"x": "easting", "y": "northing", "yaw": "hdg"}
    assert assign(["north", "east", "down"]).columns == {"x": "north", "y": "east", "z": "down"}
    # A desired speed alone is no third axis.
    assert "vz" not in assign(["v_d", "steer"]).columns


NUMBERED = {
    "omega_1 omega_2 omega_3": "wx wy wz",
    "omega_0 omega_1 omega_2": "wx wy wz",
    "pos[1] pos[2] pos[3]": "x y z",
    "omega1_cmd omega2_cmd omega3_cmd omega4_cmd": "motor1 motor2 motor3 motor4",
    "f0 f1 f2 f3": "motor1 motor2 motor3 motor4",
    "motor1_fr motor2_rl motor3_fl motor4_rr": "motor1 motor3 motor4 motor2",
    "pwm_front_left pwm_front_right pwm_back_left pwm_back_right": "motor4 motor1 motor3 motor2",
    "vx_w vy_w vz_w p q r": "vx vy vz wx wy wz",
}


@pytest.mark.parametrize("names", NUMBERED)
def test_columns_that_are_counted_or_placed(names: str) -> None:
    assert assign(names.split()).columns == dict(zip(NUMBERED[names].split(), names.split(), strict=True))


def test_counts_of_thrust_are_left_to_the_user(tmp_path: Path) -> None:
    log = pd.read_csv(example_flight())
    total = log[[f"motor{i}_cmd" for i in range(1, 5)]].sum(axis=1)
    log.assign(**{"stabilizer.thrust": np.round(total / 4 * 65535)}).to_csv(tmp_path / "log.csv", index=False)
    found = inspect_logs(tmp_path / "log.csv")
    assert "thrust" not in found.spec.columns
    row = next(row for row in found.rows if row.column == "stabilizer.thrust")
    assert (row.unit, row.confidence) == ("?", "unknown")
    line = next(line for line in found.toml().splitlines() if line.startswith("# thrust ="))
    accepted = LogSpec.parse(found.toml().replace(line, line[2:]))
    assert accepted.columns["thrust"].column == "stabilizer.thrust"


@pytest.mark.parametrize(("others", "meaning"), [((), "thrust command"), (("steering_angle",), "?")])
def test_a_throttle_is_a_thrust_of_what_flies(others: tuple[str, ...], meaning: str, tmp_path: Path) -> None:
    """In a car it is no thrust."""
    log = pd.read_csv(example_flight())
    motors = [f"motor{i}_cmd" for i in range(1, 5)]
    log = log.assign(throttle=log[motors].sum(axis=1) / 4, **dict.fromkeys(others, 0.1 * log["vx"]))
    log.drop(columns=motors).to_csv(tmp_path / "log.csv", index=False)
    found = inspect_logs(tmp_path / "log.csv")
    assert [row.meaning for row in found.rows if row.column == "throttle"] == [meaning]
    offered = [line for line in found.toml().splitlines() if line.startswith('# thrust = { column = "throttle"')]
    assert len(offered) == (meaning != "?")
    assert all("mass in kg × " in line and "hides a mass that you do not know" in line for line in offered)


def test_a_thrust_of_0_to_1_is_offered_in_kilograms_of_the_robot(tmp_path: Path) -> None:
    """In N the robot would weigh grams; what the mean carries is its weight."""
    log = pd.read_csv(example_flight())
    total = log[[f"motor{i}_cmd" for i in range(1, 5)]].sum(axis=1)
    log.assign(thrust_sp=total / 4).to_csv(tmp_path / "log.csv", index=False)
    lines = inspect_logs(tmp_path / "log.csv").toml().splitlines()
    offered = next(line for line in lines if line.startswith("# thrust ="))
    times = float(offered.partition("mass in kg × ")[2].split()[0])
    assert times * float(total.mean()) / 4 == pytest.approx(GRAVITY, rel=1e-3)
    accepted = LogSpec.parse(
        "\n".join(line for line in lines if not line.startswith("thrust =")).replace(offered, offered[2:])
    )
    assert accepted.columns["thrust"].column == "thrust_sp"


def test_without_stamps_the_rate_is_unknown(tmp_path: Path) -> None:
    pd.read_csv(example_flight()).drop(columns="t").to_csv(tmp_path / "log.csv", index=False)
    found = inspect_logs(tmp_path / "log.csv")
    assert found.spec.time.column == ""
    assert next(row for row in found.rows if row.meaning == "time").confidence == "unknown"
    filled = LogSpec.parse(found.toml().replace("rate = 0.0", "rate = 100"))
    assert filled == replace(found.spec, time=replace(found.spec.time, rate=100.0))


def test_remarks_on_columns(tmp_path: Path) -> None:
    log = pd.read_csv(example_flight())
    log = log.assign(zero=0.0, mode="HOVER")
    log.to_csv(tmp_path / "log.csv", index=False)
    rows = inspect_logs(tmp_path / "log.csv").rows
    remarks = {name: "; ".join(row.evidence for row in rows if row.column == name) for name in log.columns}
    assert "constant at 0" in remarks["zero"]
    assert next(row.evidence for row in rows if row.column == "mode") == "text, left out"
    assert [row.confidence for row in rows if row.column == "zero"] == ["unknown"]  # one row for both


def test_a_gap_and_a_late_start_are_named(tmp_path: Path) -> None:
    log = pd.read_csv(example_flight())
    late = log["t"].to_numpy().copy()
    late[1:] += 0.07
    late[400:] += 0.3
    log.assign(t=late).to_csv(tmp_path / "log.csv", index=False)
    found = inspect_logs(tmp_path / "log.csv")
    assert found.spec.drop_first == 1
    log.drop(index=1).to_csv(tmp_path / "lost.csv", index=False)
    log.to_csv(tmp_path / "whole.csv", index=False)
    of_some = inspect_logs([tmp_path / name for name in ("lost.csv", "whole.csv", "whole.csv")])
    assert of_some.spec.drop_first == 0
    assert "0.32 s before row 402 of log.csv" in next(row.evidence for row in found.rows if "gap" in row.meaning)


def test_logs_of_different_kinds_are_not_mixed(tmp_path: Path) -> None:
    log = pd.read_csv(example_flight())
    log.to_csv(tmp_path / "a.csv", index=False)
    log.drop(columns="vbat").to_csv(tmp_path / "b.csv", index=False)
    with pytest.raises(DataError, match=r"b\.csv: expected the same columns as a\.csv, found a difference in vbat"):
        inspect_logs(tmp_path)
    log.head(5).to_csv(tmp_path / "b.csv", index=False)
    with pytest.raises(DataError, match="at least 20 rows"):
        inspect_logs(tmp_path / "b.csv")


NAMES = {
    "stateEstimate.vx": ("velocity", "x", "state"),
    "stateEstimateZ.ratePitch": ("rate", "y", "state"),
    "pm.vbatMV": ("battery", "", "state"),
    "pwm.m1_pwm": ("motor", "1", "command"),
    "controller.rollRate": ("rate", "x", "command"),
    "ctrltarget.x": ("position", "x", "reference"),
    "vehicle_attitude.q[0]": ("quaternion", "0", "state"),
    "vehicle_attitude_setpoint.q_d[3]": ("quaternion", "3", "command"),
    "vehicle_angular_velocity.xyz[1]": ("rate", "y", "state"),
    "trajectory_setpoint.position[0]": ("position", "x", "reference"),
    "/mavros/local_position/pose/pose.orientation.x": ("quaternion", "x", "state"),
    "twist.twist.angular.z": ("rate", "z", "state"),
    "imu.linear_acceleration.z": ("acceleration", "z", "state"),
    "ang_vel_x": ("rate", "x", "state"),
    "x_dot": ("velocity", "x", "state"),
    "psi_dot": ("rate", "z", "state"),
    "drive.steering_angle": ("steer", "", "command"),
    "%time": ("time", "", "state"),
    "vel_w_x": ("velocity", "x", "state"),
    "x_w": ("position", "x", "state"),
    "u_steer": ("steer", "", "command"),
    "delta_f": ("steer", "", "command"),
    "front_wheel_angle": ("steer", "", "command"),
    "battery_status.voltage_v": ("battery", "", "state"),
    "T_cmd": ("thrust", "", "command"),
    "t_cmd": ("time", "", "command"),
    "speed_request": ("speed", "", "command"),
}
UNITS = {
    "thrust_cmd_N": ("thrust", "N"),
    "thrust_mN": ("thrust", "mN"),
    "thrust_sp_g": ("thrust", "gf"),
    "thrust_grams": ("thrust", "gf"),
    "thrust_m_s2": ("thrust", "m/s^2"),
    "v_set_kmh": ("speed", "km/h"),
    "speed_m_per_s": ("speed", "m/s"),
    "gyro_x_deg_s": ("rate", "deg/s"),
    "yaw_deg_s": ("rate", "deg/s"),
    "vbat_mV": ("battery", "mV"),
    "v_n": ("velocity", ""),
    "wheel_angle_deg": ("steer", "deg"),
    "road_wheel_deg": ("steer", "deg"),
}


@pytest.mark.parametrize("name", NAMES)
def test_names(name: str) -> None:
    found = read_name(name)
    assert found is not None
    assert (found.quantity, found.axis, found.role) == NAMES[name]


@pytest.mark.parametrize("name", UNITS)
def test_units_in_names(name: str) -> None:
    found = read_name(name)
    assert found is not None
    assert (found.quantity, found.unit) == UNITS[name]


@pytest.mark.parametrize(
    "name",
    [
        "battery_current",
        "foo",
        "id",
        "temperature",
        "rssi",
        "v_xy_valid",
        "delta_q_reset[0]",
        "delta_xy[0]",
        "x_std",
        "delta_z",
        "delta_vxy[0]",
        "delta_heading",
        "left_wheel_angle",
    ],
)
def test_names_that_say_nothing(name: str) -> None:
    assert read_name(name) is None
