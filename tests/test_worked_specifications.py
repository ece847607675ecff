"""The page of worked specifications, on tables as those programs write them: one known moment each."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from log_files import saved

from sym2real import rotation
from sym2real.logs import LogSpec, read_log
from sym2real.logs.pose import attitude
from sym2real.trajectory import Trajectory

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
    log = read(tmp_path, "Crazyflie", **cells)
    assert log.column("x")[5] == 1.5
    assert turned(log) == pytest.approx([0.0, -30.0, 0.0], abs=1e-9)
    assert log.column("wz")[5] == pytest.approx(np.pi)
    assert log.column("thrust")[5] == pytest.approx(36000 / 111342, rel=1e-4)


def test_motive(tmp_path: Path) -> None:
    """Turned to the left by 30° about the axis that is up."""
    log = read(tmp_path, "OptiTrack", X=1.0, Y=3.0, Z=2.0, qw=np.cos(HALF), qy=np.sin(HALF), speed_cmd=0.7)
    assert [log.column(name)[5] for name in "xyz"] == [1.0, -2.0, 3.0]
    assert turned(log) == pytest.approx([0.0, 0.0, 30.0], abs=1e-9)
    assert log.column("speed")[5] == 0.7


def test_vicon(tmp_path: Path) -> None:
    log = read(tmp_path, "Vicon", TX=1000.0, TY=-500.0, RZ=90.0, steer_cmd=10.0)
    assert (log.dt, log.column("x")[5], log.column("y")[5]) == pytest.approx((0.01, 1.0, -0.5))
    assert log.column("sin_yaw")[5] == pytest.approx(1.0)
    assert log.column("steer")[5] == pytest.approx(np.radians(10.0))
