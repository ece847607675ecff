"""The page of worked specifications, on tables as those programs write them: one known moment each."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from log_files import saved

from sym2real import rotation
from sym2real.errors import DataError
from sym2real.logs import LogSpec, inspect_logs, read_log, read_logs
from sym2real.logs.pose import attitude
from sym2real.logs.table import read_table
from sym2real.trajectory import Array, Trajectory

PAGE = (Path(__file__).parents[1] / "docs" / "worked_specifications.md").read_text(encoding="utf-8")
SPECS = dict(re.findall(r"^## (\w+).*?```toml\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE))
ROWS = 20
HALF = np.radians(15.0)


def read(folder: Path, name: str, **cells: float) -> Trajectory:
    """A log that stands still, with these cells and zeros in all other columns of the specification."""
    spec = LogSpec.parse(SPECS[name])
    step = {"us": 20_000.0, "ms": 20.0, "s": 0.02}[spec.time.unit]
    stamps = {spec.time.column: step * np.arange(ROWS)} if spec.time.column else {}
    known = {column: np.full(ROWS, cells.get(column, 0.0)) for column in spec.sources if column not in stamps}
    assert not cells.keys() - known.keys()
    return read_log(saved(folder, stamps | known), spec)


def turned(log: Trajectory) -> list[float]:
    """Roll, pitch and yaw in degrees."""
    angles: list[float] = np.degrees(rotation.to_euler(attitude(log))[5].numpy()).tolist()
    return angles


def test_every_program_of_the_page_is_read_here() -> None:
    assert [*SPECS] == ["PX4", "ArduPilot", "Crazyflie", "OptiTrack", "Vicon"]


def test_px4(tmp_path: Path) -> None:
    """Nose up by 30°, north of the origin, east of it, above it."""
    pose = {"x": 1.0, "y": 2.0, "z": -3.0, "q[0]": np.cos(HALF), "q[2]": np.sin(HALF)}
    log = read(tmp_path, "PX4", **pose, **{"thrust_body[2]": -0.5, "xyz[1]": 0.4, "pitch": 0.4})
    assert [log.column(name)[5] for name in "xyz"] == [1.0, -2.0, 3.0]
    assert turned(log) == pytest.approx([0.0, -30.0, 0.0], abs=1e-9)  # z up, x ahead: nose up turns about -y
    assert (log.column("thrust")[5], log.column("wy")[5], log.column("wy_cmd")[5]) == (18.0, -0.4, -0.4)


def test_ardupilot(tmp_path: Path) -> None:
    log = read(tmp_path, "ArduPilot", PN=1.0, PE=2.0, PD=-3.0, Pitch=30.0, AOut=0.5, R=90.0, YDes=90.0)
    assert [log.column(name)[5] for name in "xyz"] == [1.0, -2.0, 3.0]
    assert turned(log) == pytest.approx([0.0, -30.0, 0.0], abs=1e-9)
    assert log.column("thrust")[5] == 18.0
    assert (log.column("wx")[5], log.column("wz_cmd")[5]) == pytest.approx((np.pi / 2, -np.pi / 2))


def test_cfclient(tmp_path: Path) -> None:
    cells = {"stateEstimateZ.x": 1500.0, "stabilizer.pitch": 30.0, "gyro.z": 180.0, "stabilizer.thrust": 36000.0}
    log = read(tmp_path, "Crazyflie", **cells, **{"controller.pitchRate": 90.0, "gyro.y": -90.0})
    assert log.column("wy_cmd")[5] == log.column("wy")[5] == pytest.approx(-np.pi / 2)  # as the firmware's rate loop
    assert log.column("x")[5] == 1.5
    assert turned(log) == pytest.approx([0.0, -30.0, 0.0], abs=1e-9)
    assert log.column("wz")[5] == pytest.approx(np.pi)
    assert log.column("thrust")[5] == pytest.approx(36000 / 111342, rel=1e-4)


MOTIVE = """Format Version,1.23,Take Name,Take 1,Capture Frame Rate,50.000000,Rotation Type,Quaternion,Units,Meters

,,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body
,,car,car,car,car,car,car,car,car
,,"5FD8","5FD8","5FD8","5FD8","5FD8","5FD8","5FD8","5FD8"
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,
"""
VICON = """Objects
100
,,car:car
Frame,Sub Frame,RX,RY,RZ,TX,TY,TZ
,,deg,deg,deg,mm,mm,mm
"""


def captured(folder: Path, head: str, rows: Array, commands: Array) -> list[Path]:
    """What a motion capture writes, numbered, and two commands beside it, whose stamps go by its names."""
    capture, sent = folder / "capture.csv", folder / "commands.csv"
    capture.write_text(head + "\n".join(",".join(f"{cell:.9g}" for cell in row) for row in rows) + "\n")
    names = "steer_cmd,speed_cmd" if commands.shape[1] == 2 else "Time (Seconds),steering_cmd,speed_cmd"
    np.savetxt(sent, commands, delimiter=",", header=names, comments="")
    return [capture, sent]


def test_motive(tmp_path: Path) -> None:
    """Turned to the left by 30° about the axis that is up."""
    time = 0.02 * np.arange(ROWS)
    rows = [[i, t, 0.0, np.sin(HALF), 0.0, np.cos(HALF), 1.0, 3.0, 2.0, 1e-4] for i, t in enumerate(time)]
    commands = np.column_stack([time, np.full((ROWS, 2), [0.1, 0.7])])
    (log,) = read_logs(captured(tmp_path, MOTIVE, np.array(rows), commands), LogSpec.parse(SPECS["OptiTrack"]))
    assert [log.column(name)[5] for name in "xyz"] == [1.0, -2.0, 3.0]
    assert turned(log) == pytest.approx([0.0, 0.0, 30.0], abs=1e-6)
    assert log.column("speed")[5] == 0.7


def test_vicon(tmp_path: Path) -> None:
    rows = [[1 + i, 0, 0.1, 0.1, 90.0, 1000.0, -500.0, 50.0] for i in range(ROWS)]
    files = captured(tmp_path, VICON, np.array(rows), np.full((ROWS, 2), [10.0, 0.7]))
    (log,) = read_logs(files, LogSpec.parse(SPECS["Vicon"]))
    assert (log.dt, log.column("x")[5], log.column("y")[5]) == pytest.approx((0.01, 1.0, -0.5))
    assert log.column("sin_yaw")[5] == pytest.approx(1.0)
    assert log.column("steer")[5] == pytest.approx(np.radians(10.0))


def test_an_inspection_knows_the_words_of_vicon(tmp_path: Path) -> None:
    path, _ = captured(tmp_path, VICON, np.random.default_rng(0).normal(size=(60, 8)), np.zeros((60, 2)))
    proposed = inspect_logs(path).spec
    assert (proposed.attitude.euler, proposed.attitude.unit) == (("RX.deg", "RY.deg", "RZ.deg"), "deg")
    assert (proposed.columns["x"].column, proposed.columns["x"].unit) == ("TX.mm", "mm")


def test_two_bodies_are_told_apart_by_the_lines_above(tmp_path: Path) -> None:
    """Vicon names a body above the first of its columns; an error names the line of the file."""
    head = "Objects\n100\n,,one:one,,,two:two,,\nFrame,Sub Frame,TX,TY,TZ,TX,TY,TZ\n,,mm,mm,mm,mm,mm,mm\n"
    path = tmp_path / "two.csv"
    path.write_text(head + "1,0,1,2,3,4,5,6\n" * ROWS)
    assert [*read_table(path).columns][2:6] == ["one:one.TX.mm", "one:one.TY.mm", "one:one.TZ.mm", "two:two.TX.mm"]
    path.write_text(head + "1,0,1,2,3,4,5,6\n" * ROWS + "1,0,1\n" + "1,0,1,2,3,4,5,6\n" * 2)
    with pytest.raises(DataError, match=f"row {6 + ROWS}: expected 8 values"):
        read_table(path)


@pytest.mark.parametrize("y_up", [True, False])
def test_an_inspection_sees_which_axis_is_up(y_up: bool, tmp_path: Path) -> None:
    """A car in a weaving drive, captured with y up and with z up."""
    time = 0.02 * np.arange(400)
    heading = 0.8 * np.sin(time)
    x, y = (np.cumsum(0.02 * part(heading)) for part in (np.cos, np.sin))
    level, up, error = np.full(400, 1e-4), np.full(400, 0.05), np.full(400, 3e-4)
    sine, cosine = np.sin(heading / 2), np.cos(heading / 2)
    turn, place = ([level, sine, -level], [x, up, -y]) if y_up else ([level, level, sine], [x, y, up])
    rows = np.column_stack([np.arange(400), time, *turn, cosine, *place, error])
    path, _ = captured(tmp_path, MOTIVE, rows, np.zeros((400, 2)))
    proposed = inspect_logs(path).spec
    assert proposed.flip == (("Position.Z", "Rotation.Z") if y_up else ())
    log = read_log(path, proposed)
    np.testing.assert_allclose(log.column("y"), y, atol=1e-6)
    np.testing.assert_allclose(log.column("qz"), sine, atol=1e-6)


@pytest.mark.parametrize("robot", ["a car on a rough road", "a quadrotor in drag"])
def test_what_pitches_and_hardly_turns_does_not_stand_along_y(robot: str, tmp_path: Path) -> None:
    """Its tilt accelerates it little: a road's does not, and drag is as large as what a slow swing leans for."""
    time = 0.02 * np.arange(600)
    if robot == "a car on a rough road":
        pitch, x, z = np.radians(4.0) * np.sin(7.0 * time), 1.2 * time, 0.05 + 0.01 * np.sin(7.0 * time)
    else:
        pitch, x, z = 0.1 * np.sin(0.5 * time), -1.9 * np.cos(0.5 * time), 1.0 + 0.05 * np.sin(time)
    yaw = np.radians(1.0) * np.sin(0.3 * time)
    level, sine, turn, cosine = np.zeros(600), np.sin(pitch / 2), np.sin(yaw / 2), np.cos(pitch / 2) * np.cos(yaw / 2)
    rows = np.column_stack([np.arange(600), time, level, sine, turn, cosine, x, 0.1 * time, z, np.full(600, 3e-4)])
    path, _ = captured(tmp_path, MOTIVE, rows, np.zeros((600, 2)))
    proposed = inspect_logs(path).spec
    assert (proposed.flip, proposed.columns["z"].column) == ((), "Position.Z")


def test_measured_velocities_keep_an_inspection_from_turning_the_world(tmp_path: Path) -> None:
    time = 0.02 * np.arange(400)
    heading = 0.8 * np.sin(time)
    x, y = (np.cumsum(0.02 * part(heading)) for part in (np.cos, np.sin))
    columns = {"t": time, "x": x, "y": np.full(400, 0.05), "z": -y, "vx": np.cos(heading), "vz": -np.sin(heading)}
    columns |= {"qw": np.cos(heading / 2), "qx": 1e-4 + 0 * x, "qy": np.sin(heading / 2), "qz": 0 * x}
    found = inspect_logs(saved(tmp_path, columns))
    assert found.spec.flip == ()
    assert "y may be up" in {row.meaning for row in found.rows}
