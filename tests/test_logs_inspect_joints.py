"""Inspection for a robot's own joints: what names and slopes say is proposed, what they do not say is left open."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import two_links
from cli_results import result_of
from log_files import saved

from sym2real import example_flight, quadrotor
from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, diagnose
from sym2real.errors import DataError
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.logs import LogSpec, inspect_logs, read_logs
from sym2real.logs.dropouts import lost_in_reading
from sym2real.logs.joint_names import match_own
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.reach import in_reach
from sym2real.trajectory import Array, Trajectory

LINKS = Robot.from_mjcf(two_links.MJCF, name="links", dt=two_links.STEP)
LAYOUTS = LINKS.layouts
OWN = two_links.COLUMNS[1:]
TARGET = '<actuator><position name="target" joint="q1" kp="8" ctrlrange="-2 2"/>'
SERVO = Robot.from_mjcf(two_links.MJCF.replace("<actuator>", TARGET), actions=["target"], name="servo")


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ("Q1 Q2 dQ1 dQ2 Tau1 Tau2", "Q1 Q2 dQ1 dQ2 Tau1 Tau2"),
        ("theta1 theta2 omega1 omega2 u1 u2", "theta1 theta2 omega1 omega2 u1 u2"),
        ("joint1_pos joint2_pos joint1_vel joint2_vel joint1_torque joint2_torque", ""),
        ("/js.position[0] /js.position[1] /js.velocity[0] /js.velocity[1] /js.effort[0] /js.effort[1]", ""),
        ("q_0 q_1 qd_0 qd_1 tau_0 tau_1", ""),
        ("q1_deg q2_deg qd1 qd2 tau1_meas tau2_meas tau1_cmd tau2_cmd", "q1_deg q2_deg qd1 qd2 tau1_cmd tau2_cmd"),
        ("q1 q2 q1_des q2_des ddq1 ddq2 dq1 dq2 current1 current2", "q1 q2 dq1 dq2 - -"),
        ("q2_deg q1_deg q2_dps q1_dps tau2_nm tau1_nm", "q1_deg q2_deg q1_dps q2_dps tau1_nm tau2_nm"),
        ("q1 [deg]|q2 [deg]|q1_rate [rad/s]|q2_rate [rad/s]|tau1 [N m]|tau2 [N m]", ""),
        ("ax1_pos_deg ax2_pos_deg ax1_vel_dps ax2_vel_dps ax1_torque ax2_torque", ""),
        ("A1_pos A2_pos A1_vel A2_vel a1 a2", "A1_pos A2_pos A1_vel A2_vel - -"),
        ("q1 q2 q3 dq1 dq2 dq3 tau1 tau2 tau3", "q1 q2 dq1 dq2 tau1 tau2"),
        ("shoulder elbow shoulder_vel elbow_vel tau_a tau_b", "- - - - - -"),
        ("position[0] position[1] position[2] velocity[0] velocity[1] velocity[2]", "- - - - - -"),
        ("pos_1 pos_2 angle_1 angle_2 tau1 tau2", "- - - - tau1 tau2"),
        (
            "present_position_1 present_position_2 q1_vel q2_vel present_current_1 present_current_2",
            "present_position_1 present_position_2 q1_vel q2_vel - -",
        ),
    ],
)
def test_names_that_say_enough_are_matched_and_no_others(names: str, found: str) -> None:
    called, wanted = (text.split("|") if "|" in text else text.split() for text in (names, found or names))
    matching = match_own(("t", *called), LAYOUTS, {"tau1": "q1", "tau2": "q2"})
    assert [matching.pairs[column].source if column in matching.pairs else "-" for column in OWN] == wanted
    assert set(matching.open) == {column for column, source in zip(OWN, wanted, strict=True) if source == "-"}


def test_a_column_goes_by_a_word_of_a_longer_name_where_one_name_alone_has_it() -> None:
    robot = ROBOTS["cart_pole"]
    moved = {"drive": "slider"}
    found = match_own(["Trolley slider [mm]", "Pole Angle [deg]", "Drive Force [N]"], robot.layouts, moved).pairs
    assert {column: (match.source, match.sure) for column, match in found.items()} == {
        "slider": ("Trolley slider [mm]", False), "pole": ("Pole Angle [deg]", True),
        "drive": ("Drive Force [N]", True),
    }  # fmt: skip
    both = match_own(["left slider", "right slider", "pole"], robot.layouts, moved)
    assert "slider" not in both.pairs
    assert "left slider" in both.open["slider"]


def test_the_name_of_a_joint_says_no_quantity() -> None:
    """A twist is a velocity elsewhere, and a motor commands."""
    text = "".join(f'<body><joint name="{name}"/><geom size="1"/></body>' for name in ("motor", "twist"))
    motor = '<actuator><motor name="torque" joint="motor" ctrlrange="-1 1"/></actuator>'
    robot = Robot.from_mjcf(f"<mujoco><worldbody>{text}</worldbody>{motor}</mujoco>", name="axis")
    found = match_own(["motor_angle", "twist_angle", "twist_rate", "torque"], robot.layouts, {"torque": "motor"}).pairs
    assert {column: match.source for column, match in found.items()} == {
        "motor": "motor_angle", "twist": "twist_angle", "twist_rate": "twist_rate", "torque": "torque",
    }  # fmt: skip


def test_a_command_of_equations_of_ones_own_may_be_called_after_any_quantity() -> None:
    layouts = Layouts(Layout.of(["x", "y", "sin_yaw", "cos_yaw", "vx", "vy", "wz"]), Layout.of(["steer", "accel"]))
    matching = match_own(["t", "steer_cmd", "accel_cmd", "imu_ax"], layouts, {})
    assert matching.pairs["accel"].source == "accel_cmd"


def test_a_servos_own_name_beside_a_unit_is_its_command_where_the_joint_stands_beside_it() -> None:
    """Counted names of commands are no joints', whose own names stand there."""
    moved = {"target": "q1"}
    both = match_own(["target_deg", "q1_deg", "q1_dps"], SERVO.layouts, moved)
    assert {column: match.source for column, match in both.pairs.items()} == {
        "q1": "q1_deg", "q1_rate": "q1_dps", "target": "target_deg",
    }  # fmt: skip


def test_a_speed_of_a_wheel_that_nobody_called_a_command_is_a_line_to_fill_in() -> None:
    robot = ROBOTS["differential_drive"]
    matching = match_own(("t", "x_mm", "left_rpm", "right_rpm"), robot.layouts, robot.moved)
    assert not {"left", "right"} & {*matching.pairs}
    assert matching.open["left"] == "it may be 'left_rpm', whose name does not say that it was sent"


def test_joints_go_by_their_names_and_servos_by_what_is_wanted() -> None:
    arm = ROBOTS["arm"].layouts
    names = ["waist_pos", "shoulder/velocity", "waist_cmd", "elbow_effort", "elbow"]
    moved = {f"{joint}_motor": joint for joint in arm.state.joints}
    found = {column: match.source for column, match in match_own(names, arm, moved).pairs.items()}
    assert found == {
        "waist": "waist_pos", "shoulder_rate": "shoulder/velocity", "waist_motor": "waist_cmd",
        "elbow_motor": "elbow_effort", "elbow": "elbow",
    }  # fmt: skip
    places = arm.state.rates.items()
    glued = {joint: f"currentPosition{joint}" for joint, _ in places}
    glued |= {rate: f"currentVelocity{joint}" for joint, rate in places}
    glued |= {action: f"currentCommand{joint}" for action, joint in moved.items()}  # jiminy's; no electric current
    found = {column: match.source for column, match in match_own([*glued.values()], arm, moved).pairs.items()}
    assert found == glued
    assert match_own(["ax1_pos", "ax1_target"], SERVO.layouts, {"target": "q1"}).pairs["target"].source == "ax1_target"
    found = {c: m.source for c, m in match_own(["q1", "q1_ref", "tau1"], SERVO.layouts, {"target": "q1"}).pairs.items()}
    assert found == {"q1": "q1", "target": "q1_ref"}


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ("J1_deg J2_deg Z_mm J1_vel_dps J2_vel_dps Z_vel_mmps", "J1_deg J2_deg Z_mm J1_vel_dps J2_vel_dps Z_vel_mmps"),
        ("J1_deg J2_deg Z_mm", "J1_deg J2_deg Z_mm - - -"),
        ("J1_deg J2_deg Z_mm Y_mm", "J1_deg J2_deg - - - -"),
        ("J1_deg J2_deg J3_deg Z_mm", "- - Z_mm - - -"),
        ("J1 J2 Z", "- - - - - -"),
    ],
)
def test_hinges_and_slides_are_counted_each_alone_where_units_say_which_is_which(names: str, found: str) -> None:
    """A SCARA arm: two hinges in deg and a spindle in mm; names without units say nothing of the kind."""
    places = {"shoulder": "rad", "elbow": "rad", "quill": "m"}
    fields = [Field(joint, (joint,), unit) for joint, unit in places.items()]
    fields += [Field(f"{joint}_rate", (f"{joint}_rate",), f"{unit}/s") for joint, unit in places.items()]
    scara = Layouts(Layout(tuple(fields)), Layout(()))
    matching = match_own(names.split(), scara, {})
    own = [*scara.state]
    assert [matching.pairs[column].source if column in matching.pairs else "-" for column in own] == found.split()
    assert not any(match.sure for match in matching.pairs.values())


def test_what_counts_from_zero_is_a_guess_that_says_so(tmp_path: Path) -> None:
    columns = ("time", "position[0]", "position[1]", "velocity[0]", "velocity[1]", "effort[0]", "effort[1]")
    inspection = inspect_logs(
        two_links.write(tmp_path / "log.csv", two_links.swings(seconds=3.0), columns), layouts=LAYOUTS
    )
    rows = {row.column: row for row in inspection.rows}
    assert {rows[column].confidence for column in columns[1:]} == {"guess"}
    assert "number 2 of 2, in the order of the model's" in rows["position[1]"].evidence


def foreign(file: Path, rows: Array, angle: float, rate: float, columns: str) -> Path:
    """A log with angles and rates in other units and under other names; stamps in ms."""
    values = [1e3 * rows[:, 0], angle * rows[:, 1], angle * rows[:, 2], rate * rows[:, 3], rate * rows[:, 4]]
    return two_links.write(file, np.column_stack([*values, rows[:, 5:]]), ("stamp_ms", *columns.split(), "u1", "u2"))


DEGREES = 180.0 / np.pi


@pytest.mark.parametrize(
    ("angle", "rate", "columns", "part"),
    [
        (DEGREES, DEGREES, "theta1 theta2 omega1 omega2", 1.0),
        (DEGREES, 1.0, "theta1 theta2 omega1 omega2", 0.05),  # too small for degrees, but for its rate
        (1.0, 60 / (2 * np.pi), "theta1 theta2 omega1 omega2", 1.0),
        (DEGREES, DEGREES, "theta1_deg theta2_deg omega1_deg omega2_deg", 0.05),
    ],
)
def test_a_proposal_gives_the_log_back(angle: float, rate: float, columns: str, part: float, tmp_path: Path) -> None:
    rows = two_links.swings(seconds=4.0)
    rows[:, 1:5] *= part
    plain = read_logs(two_links.write(tmp_path / "plain.csv", rows), layouts=LAYOUTS)[0]
    file = foreign(tmp_path / "foreign.csv", rows, angle, rate, columns)
    proposed = LogSpec.parse(inspect_logs(file, layouts=LAYOUTS).toml())
    log = read_logs(file, proposed, LAYOUTS)[0]
    for group in ("time", "state", "action"):
        np.testing.assert_allclose(getattr(log, group), getattr(plain, group), atol=1e-6)


def test_joints_far_outside_their_range_are_refused_before_anything_is_said_of_effects() -> None:
    rows = two_links.swings(seconds=4.0)
    counts = np.round(rows[:, 1:5] * 4096 / (2 * np.pi) + 2048)
    log = Trajectory.from_arrays(np.radians(counts), rows[:, 5:7], LAYOUTS, dt=two_links.STEP, name="servo")
    with pytest.raises(DataError, match=r"servo, column 'q1': expected a joint in its range of -2\.5 to 2\.5 rad"):
        diagnose(LINKS.nominal(), Dataset([log]))


@pytest.mark.parametrize("turns", [-2, 1])
def test_a_joint_that_lies_whole_turns_beside_its_range_is_put_back(turns: int) -> None:
    rows = two_links.swings(seconds=4.0)
    log = Trajectory.from_arrays(rows[:, 1:5], rows[:, 5:7], LAYOUTS, dt=two_links.STEP, name="encoder")
    beside = replace(log, state=log.state + 2.0 * np.pi * turns * np.array([0.0, 1.0, 0.0, 0.0]))
    (back,) = in_reach(LINKS, Dataset([beside]))
    np.testing.assert_allclose(back.state, log.state, atol=1e-12)
    assert lost_in_reading([back]) == ["encoder: q2 is put into its range by whole turns"]
    (same,) = in_reach(LINKS, Dataset([log]))
    assert same is log


def test_ranges_are_those_of_the_file() -> None:
    assert LINKS.ranges == {"q1": (-2.5, 2.5), "q2": (-2.5, 2.5)}  # the torques are no places
    assert {*ROBOTS["arm"].ranges} == {*ROBOTS["arm"].layouts.state.joints}
    assert ROBOTS["crazyflie"].ranges == {}


def test_a_rate_must_move_like_the_slope_of_its_joint(tmp_path: Path) -> None:
    """A column that only its name makes a rate gives way to the slope; one that is mirrored is suspected."""
    rows = two_links.swings(seconds=4.0)
    rows[:, 3] = np.random.default_rng(0).normal(size=len(rows))
    rows[:, 4] *= -1.0
    inspection = inspect_logs(two_links.write(tmp_path / "log.csv", rows), layouts=LAYOUTS)
    assert inspection.spec.derive == ("rate",)
    assert {*inspection.spec.columns} == {*OWN} - {"q1_rate"}
    assert inspection.suspected_flips == ("q2_rate",)
    assert any("does not move like the slope of q1" in row.evidence for row in inspection.rows)


def test_what_is_missing_is_said_where_it_is_to_be_filled_in(tmp_path: Path) -> None:
    rows = two_links.swings(seconds=2.0)
    file = two_links.write(tmp_path / "log.csv", rows[:, [0, 1, 2, 5]], ("time", "q1", "q2", "watts"))
    inspection = inspect_logs(file, layouts=LAYOUTS)
    assert inspection.spec.derive == ("rate",)
    assert {row.meaning for row in inspection.rows if row.confidence == "unknown"} == {
        "tau1 is missing", "tau2 is missing", "?",
    }  # fmt: skip
    assert '# tau1 = "…"  # N m: no column is called like it' in inspection.toml()
    assert LogSpec.parse(inspection.toml()).columns.keys() == {"q1", "q2"}


@pytest.mark.parametrize(
    "columns",
    [
        two_links.COLUMNS,
        ("t", "theta1", "theta2", "omega1", "omega2", "torque1", "torque2"),
        ("t", "position[0]", "position[1]", "velocity[0]", "velocity[1]", "effort[0]", "effort[1]"),
    ],
)
def test_without_a_model_joints_are_no_axes(columns: tuple[str, ...], tmp_path: Path) -> None:
    file = two_links.write(tmp_path / "log.csv", two_links.swings(seconds=2.0), columns)
    found = result_of(["inspect", str(file)], tmp_path)
    assert LogSpec.parse(found["spec"]).columns == {}
    assert any("nominal mjcf" in remark for remark in found["nominal"]["remarks"])
    assert all("--model" in row["evidence"] for row in found["columns"] if row["meaning"] == "?")


def test_a_model_of_standard_columns_finds_what_is_found_without_it() -> None:
    layouts = quadrotor(0.03, interface="motors", attitude="measured").layouts
    plain, with_model = inspect_logs(example_flight()), inspect_logs(example_flight(), layouts=layouts)
    for name in with_model.spec.columns:
        assert with_model.spec.columns[name] == plain.spec.columns[name]
    assert {*layouts.state.columns, *layouts.action.columns} <= {*with_model.spec.columns}
    assert with_model.spec.attitude == plain.spec.attitude


@pytest.mark.slow
def test_the_same_motion_has_the_same_answer_however_it_was_logged(tmp_path: Path) -> None:
    """In degrees under other names, and without rates, which follow from the angles."""
    motions = [two_links.swings(0.2, 0.25, seed=seed, seconds=8.0) for seed in (1, 2, 3)]
    plain = [two_links.write(tmp_path / f"plain{number}.csv", rows) for number, rows in enumerate(motions)]
    names = "theta1 theta2 omega1 omega2"
    degrees = [
        foreign(tmp_path / f"d{number}.csv", rows, DEGREES, DEGREES, names) for number, rows in enumerate(motions)
    ]
    kept = ("time", "q1", "q2", "tau1", "tau2")
    places = [two_links.COLUMNS.index(column) for column in kept]
    no_rates = [
        two_links.write(tmp_path / f"n{number}.csv", rows[:, places], kept) for number, rows in enumerate(motions)
    ]

    def answer(files: list[Path], spec: LogSpec | None) -> Diagnosis:
        logs = read_logs(files, spec, LAYOUTS, dt=two_links.STEP)
        return diagnose(LINKS.nominal(), logs, exclude=["sensor_*", "time_shift:*", "*:tau?"])

    first, same, derived = (
        answer(files, None if files is plain else inspect_logs(files, layouts=LAYOUTS).spec)
        for files in (plain, degrees, no_rates)
    )
    assert [finding.effect for finding in first.findings] == ["load:hand", "joint_damping:q1"]
    for other, tolerance in ((same, 1e-5), (derived, 0.02)):
        assert [finding.effect for finding in other.findings] == [finding.effect for finding in first.findings]
        for one, another in zip(first.findings, other.findings, strict=True):
            assert another.values["value"] == pytest.approx(one.values["value"], rel=tolerance)


def test_the_command_line_names_the_robot_by_its_folder(tmp_path: Path) -> None:
    (tmp_path / "links.xml").write_text(two_links.MJCF)
    rows = two_links.swings(load=0.3, seconds=6.0)
    file = foreign(tmp_path / "log.csv", rows, DEGREES, DEGREES, "theta1 theta2 omega1 omega2")
    model, spec = str(tmp_path / "links"), str(tmp_path / "log.toml")
    made: dict[str, Any] = result_of(
        ["nominal", "mjcf", str(tmp_path / "links.xml"), "--log", str(file), "--out", model], tmp_path
    )
    assert made["dt"] == pytest.approx(two_links.STEP)  # of a log whose columns nobody has named yet
    main(["inspect", str(file), "--model", model, "--out", spec])
    assert result_of(["compare", model, str(file), "--spec", spec], tmp_path)["horizons"]


HEXAROTOR = ROBOTS["hexarotor"].layouts


@pytest.mark.parametrize(
    ("name", "found"), [("actuator_motors.control[{}]", True), ("esc{}_cmd", True), ("C{}", False)]
)
def test_six_motors_are_found_by_their_numbers_or_are_lines_to_fill_in(name: str, found: bool, tmp_path: Path) -> None:
    """A model of six rotors was asked for four, and of those that were not found nothing was said."""
    rng = np.random.default_rng(0)
    columns = {"t": 0.01 * np.arange(100), "z": np.linspace(0.0, 1.0, 100)}
    columns |= {name.format(number): rng.uniform(0.4, 0.6, 100) for number in range(6)}
    proposed = inspect_logs(saved(tmp_path, columns), layouts=HEXAROTOR)
    for number in range(6):
        if found:
            assert proposed.spec.columns[f"motor{number + 1}"].column == name.format(number)
        else:
            assert f'# motor{number + 1} = "…"  # 1: no column is called like it' in proposed.toml()


def test_a_servos_command_goes_by_its_joints_name_in_python_too(tmp_path: Path) -> None:
    time = 0.01 * np.arange(200)
    angle = np.sin(time)
    columns = {"t": time, "q1_deg": np.degrees(angle), "q2_deg": 0.5 * np.degrees(angle), "q1_cmd_deg": 57.3 * angle}
    found = inspect_logs(saved(tmp_path, columns), layouts=SERVO.layouts, moved=SERVO.moved)
    assert (found.spec.columns["target"].column, found.spec.columns["target"].unit) == ("q1_cmd_deg", "deg")


@pytest.mark.parametrize(("rate", "unit"), [(1.0, ""), (np.degrees(1.0), "deg")])
@pytest.mark.parametrize("logged", ["q1 dq1", "q1"])
def test_a_hinge_without_stops_may_turn_more_than_once_but_not_at_any_speed(
    rate: float, unit: str, logged: str, tmp_path: Path
) -> None:
    """A turntable that had turned twice was read in degrees, and of these a friction and a gain were made."""
    time = 0.01 * np.arange(1000)
    angle = 10.0 * np.sin(0.5 * time)  # rad
    columns = {"t": time, "q1": rate * angle, "dq1": rate * 5.0 * np.cos(0.5 * time), "q2": 0.1 * np.sin(time)}
    kept = {name: values for name, values in columns.items() if name in ("t", "q2", *logged.split())}
    endless = inspect_logs(saved(tmp_path, kept), layouts=LAYOUTS, endless=["q1"]).spec
    assert endless.columns["q1"].unit == unit
    assert inspect_logs(saved(tmp_path, kept), layouts=LAYOUTS).spec.columns["q1"].unit == "deg"


def test_the_only_column_that_is_left_over_is_taken_for_the_only_one_that_is_missing(tmp_path: Path) -> None:
    time = 0.01 * np.arange(300)
    columns = {"t": time, "q1": np.sin(time), "q2": np.cos(time), "tau1": np.sin(2 * time), "effort": np.cos(2 * time)}
    found = inspect_logs(saved(tmp_path, columns), layouts=LAYOUTS)
    assert found.spec.columns["tau2"].column == "effort"
    assert [row.confidence for row in found.rows if row.meaning == "tau2"] == ["guess"]
    two = inspect_logs(saved(tmp_path, columns | {"other": np.cos(time)}), layouts=LAYOUTS)
    assert "tau2" not in two.spec.columns
