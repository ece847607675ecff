"""Logs of a robot's own joints: specifications name its columns, in any unit; rates follow from coordinates."""

from pathlib import Path

import numpy as np
import pytest
import two_links

from sym2real.errors import DataError
from sym2real.logs import LogSpec, read_log
from sym2real.logs.missing import require_columns
from sym2real.robots import ROBOTS, Robot
from sym2real.trajectory import Array

LAYOUTS = Robot.from_mjcf(two_links.MJCF, name="links").layouts
TIME = np.arange(0.0, 0.6, two_links.STEP)
FOREIGN = """
    flip = ["elbow_deg", "elbow_dps"]
    [time]
    column = "stamp"
    unit = "ms"
    [columns]
    q1 = { column = "shoulder_deg", unit = "deg", zero = 90.0 }
    q2 = { column = "elbow_deg", unit = "deg" }
    q1_rate = { column = "shoulder_rpm", unit = "rpm" }
    q2_rate = { column = "elbow_dps", unit = "deg/s" }
    tau1 = { column = "amps1", scale = 0.061 }
    tau2 = { column = "milli2", unit = "mN m" }
    ref_q1 = { column = "goal_deg", unit = "deg" }
"""


def motion(time: Array) -> Array:
    """Constant accelerations, and torques that change with every row; :data:`two_links.COLUMNS` ``# (rows, 7)``."""
    place = np.stack([0.3 - 0.8 * time + 2.0 * time**2, -0.2 + 1.1 * time - 3.0 * time**2], axis=1)
    rate = np.stack([-0.8 + 4.0 * time, 1.1 - 6.0 * time], axis=1)
    torque = np.stack([np.arange(len(time)) % 7 - 3.0, np.arange(len(time)) % 5 - 2.0], axis=1)
    return np.column_stack([time, place, rate, torque])


def foreign(file: Path, rows: Array) -> Path:
    """The same log as somebody else writes it."""
    degrees, rpm = np.rad2deg(rows), rows[:, 3] * 60 / (2 * np.pi)
    own = [1e3 * rows[:, 0], degrees[:, 1] + 90.0, -degrees[:, 2], rpm, -degrees[:, 4], rows[:, 5] / 0.061]
    columns = ("stamp", "shoulder_deg", "elbow_deg", "shoulder_rpm", "elbow_dps", "amps1", "milli2", "goal_deg")
    return two_links.write(file, np.column_stack([*own, 1e3 * rows[:, 6], np.full(len(rows), 45.0)]), columns)


def test_a_log_in_degrees_is_the_log_in_radians(tmp_path: Path) -> None:
    rows = motion(TIME)
    plain = read_log(two_links.write(tmp_path / "plain.csv", rows), layouts=LAYOUTS)
    other = read_log(foreign(tmp_path / "foreign.csv", rows), LogSpec.parse(FOREIGN), LAYOUTS)
    for part in ("time", "state", "action"):
        np.testing.assert_allclose(getattr(other, part), getattr(plain, part), atol=1e-6)
    np.testing.assert_allclose(other.extra["ref_q1"], np.pi / 4)
    again = LogSpec.parse(LogSpec.parse(FOREIGN).toml())
    assert again == LogSpec.parse(FOREIGN)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_derived_rate_is_the_rate(share: float, tmp_path: Path) -> None:
    """Of constant accelerations exactly, at any stamps, before the log is brought to the model's step."""
    time = np.cumsum(two_links.STEP * (1.0 + np.random.default_rng(0).uniform(-share, share, 80)))
    rows = motion(time)
    file = two_links.write(tmp_path / "log.csv", rows[:, [0, 1, 2, 5, 6]], ("time", "q1", "q2", "tau1", "tau2"))
    spec = LogSpec.parse('derive = ["rate"]\n[time]\ncolumn = "time"')
    log = read_log(file, spec, LAYOUTS, dt=two_links.STEP)
    np.testing.assert_allclose(log.column("q1_rate"), -0.8 + 4.0 * (log.time + time[0]), atol=2e-3)
    np.testing.assert_allclose(log.column("q2_rate"), 1.1 - 6.0 * (log.time + time[0]), atol=2e-3)
    with pytest.raises(DataError, match=r'q1_rate, q2_rate \(rad/s\).*derive = \["rate"\].* computes q1_rate, q2_rate'):
        read_log(file, layouts=LAYOUTS)


def test_joints_move_between_rows_and_torques_hold(tmp_path: Path) -> None:
    """At stamps half a step beside the model's: between two rows a joint is on its way."""
    rows = motion(TIME)
    rows[:, 0] *= 1.6
    for spec in (None, LogSpec.parse('[time]\ncolumn = "time"')):
        log = read_log(two_links.write(tmp_path / "log.csv", rows), spec, LAYOUTS, dt=two_links.STEP)
        for place, joint in enumerate(("q1", "q2"), 1):
            np.testing.assert_allclose(log.column(joint), np.interp(log.time, rows[:, 0], rows[:, place]), atol=1e-9)
        assert set(np.round(log.column("tau1"), 9)) <= set(rows[:, 5])


def test_rows_without_a_joint_are_left_out(tmp_path: Path) -> None:
    rows = motion(TIME)
    rows[20, 2] = np.nan
    log = read_log(two_links.write(tmp_path / "log.csv", rows), layouts=LAYOUTS)
    assert len(log) == len(rows) - 1
    assert any("1 of 60 rows left out, for want of numbers in q2" in note for note in log.notes)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("q3 = 'q1'", r"standard columns or those of the model, found unknown column 'q3'; did you mean 'q"),
        ("q1 = { column = 'q1', unit = 'mm' }", r"column 'q1': expected a unit that fits.*known: deg, mrad, rad"),
        ("tau1 = { column = 'tau1', unit = 'N' }", r"known: N m, mN m"),
        ("q1 = { column = 'q1', unit = 'turns' }", r"a unit that fits"),
    ],
)
def test_what_does_not_fit_the_model_is_refused(text: str, match: str, tmp_path: Path) -> None:
    file = two_links.write(tmp_path / "log.csv", motion(TIME))
    with pytest.raises(DataError, match=match):
        read_log(file, LogSpec.parse(f"[time]\ncolumn = 'time'\n[columns]\n{text}"), LAYOUTS)


def test_a_robot_that_was_taken_to_fly_is_told_how_to_stay_on_the_ground() -> None:
    planar = "x y sin_yaw cos_yaw vx vy wz"
    with pytest.raises(DataError, match=f"--state {planar}` makes a model of a robot that stays on the ground"):
        require_columns("rover.csv", planar.split(), (), ROBOTS["hexarotor"].layouts)
    with pytest.raises(DataError) as flying:  # one of whose columns is not named
        require_columns("hexarotor.csv", ROBOTS["hexarotor"].layouts.state.columns[1:], (), ROBOTS["hexarotor"].layouts)
    assert "ground" not in str(flying.value)
