"""Units of roll, pitch and yaw, where the yaw counts on beyond a turn and its size tells nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from log_files import saved

from sym2real.logs import Inspection, derive, inspect_logs
from sym2real.logs.units import GRAVITY, UNITS
from sym2real.trajectory import Array

STEP, ROWS = 0.02, 1500
TIME = STEP * np.arange(ROWS)
WAYS = ("rad", "deg")


def flown(tilt: float = 0.25, spin: float = 0.6, late: float = 0.0) -> Array:
    """Roll, pitch and yaw in rad ``# (rows, 3)`` of a flight that tilts so far and spins so fast, so much later."""
    time = TIME - late
    return np.stack([tilt * np.sin(1.1 * time), tilt * np.sin(1.7 * time + 0.4), spin * time + 2.0], axis=1)


def moved(angles: Array, noise: float = 0.0) -> dict[str, Array]:
    """Time and positions of who is accelerated by his tilt, with noise of a fix in m."""
    up = derive.up(derive.from_euler(angles))
    push = GRAVITY * np.stack([up[:, 0], up[:, 1], 0.0 * TIME], axis=1)
    velocity = np.cumsum(push - push.mean(axis=0), axis=0) * STEP
    place = np.cumsum(velocity - velocity.mean(axis=0), axis=0) * STEP + [0.0, 0.0, 1.5]
    place += np.random.default_rng(4).normal(0.0, noise, place.shape)
    return {"t": TIME, **named("x y z", place)}


def named(names: str, values: Array) -> dict[str, Array]:
    return dict(zip(names.split(), values.T, strict=True))


def turned(angles: Array) -> Array:
    """What a gyro measures, rad/s."""
    return derive.body_rate(TIME, derive.from_euler(angles)) + np.random.default_rng(1).normal(0.0, 0.02, (ROWS, 3))


def measured(angles: Array) -> dict[str, Array]:
    return named("qw qx qy qz", derive.continuous(derive.from_euler(angles)))


def written(names: str, angles: Array, unit: str) -> dict[str, Array]:
    return named(names, angles / UNITS[unit][1])


def found(folder: Path, columns: dict[str, Array]) -> Inspection:
    return inspect_logs(saved(folder, columns))


def confidence(looked: Inspection, column: str) -> str:
    return next(row.confidence for row in looked.rows if row.column == column)


@pytest.mark.parametrize("unit", WAYS)
@pytest.mark.parametrize("tilt", [0.25, 0.02])
def test_commands_are_in_the_unit_in_which_the_measured_attitude_follows(
    tmp_path: Path, unit: str, tilt: float
) -> None:
    columns = moved(flown(tilt), 0.03) | measured(flown(tilt, late=0.15))
    looked = found(tmp_path, columns | written("roll_cmd pitch_cmd yaw_cmd", flown(tilt), unit))
    assert looked.spec.attitude_command is not None
    assert looked.spec.attitude_command.unit == unit
    assert confidence(looked, "roll_cmd") == "certain"


@pytest.mark.parametrize("unit", WAYS)
def test_where_no_roll_follows_the_yaw_does(tmp_path: Path, unit: str) -> None:
    columns = moved(flown(0.0)) | measured(flown(0.0))
    looked = found(tmp_path, columns | written("roll_cmd pitch_cmd yaw_cmd", flown(0.0, late=0.15), unit))
    assert looked.spec.attitude_command is not None
    assert looked.spec.attitude_command.unit == unit
    assert confidence(looked, "yaw_cmd") == "certain"


@pytest.mark.parametrize(("unit", "other"), [("rad", "deg"), ("deg", "rad")])
def test_commands_may_be_in_another_unit_than_the_attitude(tmp_path: Path, unit: str, other: str) -> None:
    angles = flown()
    columns = moved(angles) | written("roll pitch yaw", angles, unit)
    looked = found(tmp_path, columns | written("roll_cmd pitch_cmd yaw_cmd", flown(late=-0.1), other))
    assert looked.spec.attitude is not None
    assert looked.spec.attitude_command is not None
    assert (looked.spec.attitude.unit, looked.spec.attitude_command.unit) == (unit, other)


@pytest.mark.parametrize("unit", WAYS)
@pytest.mark.parametrize("gyro", ["", "rad/s", "deg/s"])
@pytest.mark.parametrize(("tilt", "noise"), [(0.25, 0.03), (0.03, 0.0)])
def test_a_tilt_is_in_the_unit_in_which_it_accelerates(
    tmp_path: Path, unit: str, gyro: str, tilt: float, noise: float
) -> None:
    """Also of a fix with noise, which is many times what it is accelerated by, and beside a gyro of unknown unit."""
    angles = flown(tilt)
    columns = moved(angles, noise) | written("roll pitch yaw", angles, unit)
    columns |= named("wx wy wz", turned(angles) / UNITS[gyro][1]) if gyro else {}
    looked = found(tmp_path, columns)
    assert looked.spec.attitude is not None
    assert looked.spec.attitude.unit == unit
    assert confidence(looked, "roll") == "certain"
    assert not gyro or (looked.spec.columns["wx"].unit or "rad/s") == gyro


@pytest.mark.parametrize("unit", WAYS)
@pytest.mark.parametrize("gyro", ["wx wy wz", "wx_dps wy_dps wz_dps"])
def test_without_a_place_a_gyro_tells(tmp_path: Path, unit: str, gyro: str) -> None:
    """That of a gyro in rad/s and of one whose name says its unit; angles and a gyro may both be in degrees."""
    angles, rates = flown(0.05), turned(flown(0.05))
    columns = {"t": TIME} | written("roll pitch yaw", angles, unit)
    columns |= named(gyro, np.degrees(rates) if "dps" in gyro else rates)
    looked = found(tmp_path, columns)
    assert looked.spec.attitude is not None
    assert looked.spec.attitude.unit == (unit if "dps" in gyro else "deg")
    sure = "guess" if (gyro, unit) == ("wx wy wz", "rad") else "certain"
    assert confidence(looked, "roll") == sure


@pytest.mark.parametrize(("tilt", "wrapped", "unit", "sure"), [
    (0.02, True, "rad", "certain"), (0.02, True, "deg", "certain"),  # by what its yaw jumps by
    (0.2, False, "deg", "certain"),  # who flies does not tilt by 11 rad
    (0.02, False, "deg", "guess"),
])  # fmt: skip
def test_without_a_place_or_a_gyro_jumps_and_sizes_tell(
    tmp_path: Path, tilt: float, wrapped: bool, unit: str, sure: str
) -> None:
    angles = flown(tilt)
    angles[:, 2] = (angles[:, 2] + np.pi) % (2.0 * np.pi) - np.pi if wrapped else angles[:, 2]
    looked = found(tmp_path, {"t": TIME} | written("roll pitch yaw", angles, unit))
    assert looked.spec.attitude is not None
    assert (looked.spec.attitude.unit, confidence(looked, "roll")) == (unit, sure)
