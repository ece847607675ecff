"""Wheels that roll on a floor: equations from the contacts, effects on wheels, the whole way, five hidden effects."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import torch
import whole_way

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.diagnosis.estimate.preparation import CONTRADICTED
from sym2real.diagnosis.faults.sanity import check
from sym2real.effects import effect
from sym2real.errors import ModelError
from sym2real.experiments.noisy_runs import Effects, noisy_runs
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.planar import STATE
from sym2real.symbolic import Equations, compile_model
from sym2real.tasks import make_task
from sym2real.trajectory import Array

DRIVE = ROBOTS["differential_drive"]
XML = Path(DRIVE.description.mjcf).read_text()
HIDDEN = [
    ("gain:right", {"value": 0.98}, {"joint_damping:right_wheel"}),
    ("joint_friction:left_wheel", {"value": 0.01}, {"offset:left"}),
    ("armature:left_wheel", {"value": 0.001}, set()),
    ("rolling_resistance", {"value": 0.1}, set()),
    ("turning_friction", {"value": 0.05}, set()),
    ("wheel_radius", {"value": 0.95}, set()),
    ("track_width", {"value": 1.05}, set()),
    ("wheel_grip", {"value": 0.1}, set()),
    ("carried_mass", {"mass": 1.0, "moment": -0.03, "inertia": 0.02}, set()),
    ("delay", {"value": 0.04}, set()),
]


@pytest.fixture(scope="module")
def base() -> Equations:
    return DRIVE.nominal()


def drives(effects: Effects = (), count: int = 4) -> Dataset:
    paths = [("circle", {}), ("lemniscate", {"period": 12.0}), ("circle", {"clockwise": True, "radius": 0.8})]
    return noisy_runs(DRIVE, [make_task(name, DRIVE, **options) for name, options in paths], effects, count=count)


def missed(equations: Equations, plant: MujocoPlant) -> tuple[Array, Array]:
    """What the equations miss of a step in the plane, and how far the simulator moves, root mean square of 20 draws."""
    model, rng, errors, moves = compile_model(equations, dtype=torch.float64), np.random.default_rng(1), [], []
    for _ in range(20):
        yaw, speed, turning = rng.uniform((-3.0, -0.8, -1.5), (3.0, 0.8, 1.5))
        state = np.array([0.3, -0.2, np.sin(yaw), np.cos(yaw), speed * np.cos(yaw), speed * np.sin(yaw), turning])
        push = np.array([0.3 * rng.uniform(-1.0, 1.0) * DRIVE.limits.push[one] for one in DRIVE.layouts.inputs])
        action = np.array([speed - 0.15 * turning, speed + 0.15 * turning]) / 0.05 + rng.uniform(-4.0, 4.0, 2)
        plant.reset(state)
        plant.push(push)
        before = plant.step(action)  # contacts have taken up what pushes
        after = plant.step(action)
        errors.append(model(*map(torch.as_tensor, (before, action, push))).numpy() - after)
        moves.append(after - before)
    return np.sqrt(np.square(errors).mean(0)), np.sqrt(np.square(moves).mean(0))


def test_equations_are_the_simulator_but_for_the_give_of_its_contacts(base: Equations) -> None:
    errors, moves = missed(base, MujocoPlant(DRIVE))
    assert (errors < 0.07 * moves).all(), errors / moves


def test_it_may_face_anywhere_where_it_stands() -> None:
    key, facing = "0.999999999 0 4.884e-05 0", "0.6 0 0 0.8"
    assert key in XML
    robot = Robot.from_mjcf(XML.replace(key, facing), name="turned", state=STATE)
    yaw = 2.0 * np.arctan2(0.8, 0.6)
    np.testing.assert_allclose(robot.start[2:4], [np.sin(yaw), np.cos(yaw)], atol=1e-9)
    errors, moves = missed(robot.nominal(), MujocoPlant(robot))
    assert (errors < 0.07 * moves).all(), errors / moves


def test_a_track_is_wider_whatever_the_wheels_are_mounted_on() -> None:
    """On arms that are bodies of their own and stand askew, as converters of descriptions make them."""
    left, end = '<body name="left_wheel" pos="0 0.15 0">', '<geom class="wheel" name="left_wheel"/>\n      </body>'
    assert left in XML
    assert end in XML
    arm = '<body pos="0 0.1 0" euler="0 0 90"><body name="left_wheel" pos="0.05 0 0" euler="0 0 -90">'
    mounted = Robot.from_mjcf(XML.replace(left, arm).replace(end, end + "</body>"), name="mounted", state=STATE)
    wider = [MujocoPlant(one, (effect("track_width", one).inject(value=1.2),)) for one in (DRIVE, mounted)]
    for _ in range(10):
        states = [plant.step(np.array([8.0, 12.0])) for plant in wider]
    np.testing.assert_allclose(*states, atol=1e-9)


def test_effects_are_the_robots_where_the_scene_has_bodies_before_it(base: Equations) -> None:
    crate = '<body name="crate" pos="3 0 0.1"><geom type="box" size="0.1 0.1 0.1"/></body>'
    robot = Robot.from_mjcf(XML.replace('<body name="robot"', crate + '<body name="robot"'), name="d", state=STATE)
    assert robot.mass == pytest.approx(DRIVE.mass)
    for key, values in (("wind", {"fx": 5.0, "fy": -3.0}), ("rolling_resistance", {"value": 0.5})):
        alone, beside = (MujocoPlant(one, (effect(key, one).inject(**values),)) for one in (DRIVE, robot))
        for _ in range(10):
            states = [plant.step(np.array([8.0, 10.0])) for plant in (alone, beside)]
        np.testing.assert_allclose(*states, atol=1e-9)


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("armature:left_wheel", {"value": 0.01}),
        ("joint_damping:right_wheel", {"value": 0.005}),
        ("joint_friction:left_wheel", {"value": 0.05}),
        ("turning_friction", {"value": 0.5}),
        ("wheel_radius", {"value": 0.9}),
        ("wheel_radius:left_wheel", {"value": 1.1}),
        ("track_width", {"value": 0.9}),
        ("servo_limit:left_wheel", {"value": 0.05}),
        ("carried_mass", {"mass": 2.0, "moment": -0.1, "inertia": 0.05}),
        ("linear_drag", {"cx": 10.0}),
        ("wind", {"fx": 5.0, "fy": -3.0}),
    ],
)
def test_an_effect_in_the_equations_is_the_effect_in_the_simulator(
    key: str, values: dict[str, float], base: Equations
) -> None:
    """Armature, damping and friction loss are those of MuJoCo's wheels, and none of the formulas."""
    plant = MujocoPlant(DRIVE, (effect(key, DRIVE).inject(**values),))
    (without, _), (left, _) = missed(base, plant), missed(effect(key, base).substitute(base, values), plant)
    assert np.linalg.norm(left[4:]) < 0.25 * np.linalg.norm(without[4:])


@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_wheels_that_spin_and_lock_move_the_robot_by_what_the_floor_holds(ahead: float, base: Equations) -> None:
    """MuJoCo's own friction cone, on a start and a stop beyond it: no more than μ times the wheels' load."""
    grip = 0.1
    plant = MujocoPlant(DRIVE, (effect("wheel_grip", DRIVE).inject(value=grip),))
    spinning = compile_model(effect("wheel_grip", base).substitute(base, {"value": grip}), dtype=torch.float64)
    rolling = compile_model(base, dtype=torch.float64)
    state = plant.reset(DRIVE.start)
    spun = rolled = torch.as_tensor(state)
    for step in range(40):
        action = ahead * np.array([15.0, 15.0]) * (step < 20)
        state = plant.step(action)
        given = torch.as_tensor(action), torch.zeros(5).double()
        spun, rolled = spinning(spun, *given), rolling(rolled, *given)
        assert abs(float(spun[4]) - state[4]) < 0.03
    assert abs(float(spun[0]) - state[0]) < 0.15 * abs(float(rolled[0]) - state[0])


def test_wide_wheels_roll_about_their_middle_and_brake_a_turn(tmp_path: Path) -> None:
    """Cylinders touch the floor at two points each, which drill as the robot turns: MuJoCo's friction brakes it."""
    narrow = 'type="ellipsoid" size="0.05 0.05 0.012"'
    assert narrow in XML
    (tmp_path / "wide.xml").write_text(XML.replace(narrow, 'type="cylinder" size="0.05 0.012"'))
    robot = Robot.from_mjcf(tmp_path / "wide.xml", state=STATE)
    for name in ("left_per_speed", "left_per_turn", "right_per_turn"):
        assert robot.numbers[name] == pytest.approx(DRIVE.numbers[name], rel=1e-3)
    equations, plant = robot.nominal(), MujocoPlant(robot)
    assert any("wide" in note for note in equations.notes)
    plant.reset(robot.start)
    models = [compile_model(found, dtype=torch.float64) for found in (equations, DRIVE.nominal())]
    states = [torch.as_tensor(robot.start)] * 2
    for _ in range(100):
        after = plant.step([-8.0, 8.0])
        states = [
            model(state, torch.tensor([-8.0, 8.0]).double(), torch.zeros(5).double())
            for model, state in zip(models, states, strict=True)
        ]
    with_width, without = (abs(float(state[6]) - after[6]) for state in states)
    assert with_width < 0.5 * without  # the rest is creep


def test_wheels_of_which_one_end_touches_where_the_file_puts_them_roll_about_their_middle(tmp_path: Path) -> None:
    """Cylinders that just reach the floor and hang down by a hair outside: what carries them at rest counts."""
    (tmp_path / "wide.xml").write_text(
        XML.replace('type="ellipsoid" size="0.05 0.05 0.012"', 'type="cylinder" size="0.05 0.012"')
        .replace('zaxis="0 1 0"', 'zaxis="0 1 1e-9"')
        .replace('qpos="0 0 0.04998356 0.999999999 0 4.884e-05 0 0 0"', 'qpos="0 0 0.05 1 0 0 0 0 0"')
    )
    numbers = Robot.from_mjcf(tmp_path / "wide.xml", state=STATE).numbers
    assert numbers["right_per_turn"] == pytest.approx(-numbers["left_per_turn"], rel=1e-3)
    assert numbers["right_per_turn"] == pytest.approx(DRIVE.numbers["right_per_turn"], rel=5e-3)


def test_a_servo_that_brakes_within_a_period_is_followed_through_it(tmp_path: Path) -> None:
    """Wheels twenty times as stiff: one period is ten of a tenth, where the plain step of the rule used to run away."""
    assert 'kv="0.05"' in XML
    (tmp_path / "stiff.xml").write_text(XML.replace('kv="0.05"', 'kv="1.0"').replace('forcerange="-0.6 0.6"', ""))
    state, action, push = torch.tensor([0.0, 0, 0, 1, 0, 0, 0]).double(), torch.tensor([4.0, 8.0]), torch.zeros(5)
    ends = []
    for dt, steps in ((0.02, 3), (0.002, 30)):
        robot = Robot.from_mjcf(tmp_path / "stiff.xml", state=STATE, dt=dt)
        model, reached = compile_model(robot.nominal(), dtype=torch.float64), state
        for _ in range(steps):
            reached = model(reached, action.double(), push.double())
        ends.append(reached.numpy())
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-4)
    np.testing.assert_allclose(ends[0][[4, 6]], (0.3, 4.0 * 0.05 / 0.3), atol=5e-3)


def test_at_a_reset_the_wheels_roll() -> None:
    """No contact slides: a radius of 5 cm and a track of 30 cm, to the depth of the contacts."""
    plant = MujocoPlant(DRIVE)
    plant.reset([0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.8])
    np.testing.assert_allclose(plant.mj_data.qvel[6:] * 0.05, [0.5 - 0.12, 0.5 + 0.12], rtol=5e-3)


def test_a_wheel_rolls_by_its_own_radius_however_far_it_sinks_into_the_floor(tmp_path: Path) -> None:
    """MuJoCo's contacts give: softer ones by more."""
    assert '<geom name="floor"' in XML
    (tmp_path / "soft.xml").write_text(XML.replace('<geom name="floor"', '<geom name="floor" solref="0.05 1"'))
    for robot in (DRIVE, Robot.from_mjcf(tmp_path / "soft.xml", state=STATE)):
        assert robot.numbers["left_per_speed"] == pytest.approx(1 / 0.05, rel=1e-4)


@pytest.mark.parametrize(("key", "values", "alike"), HIDDEN, ids=[key for key, *_ in HIDDEN])
def test_a_hidden_effect_is_named(key: str, values: dict[str, float], alike: set[str], base: Equations) -> None:
    found = diagnose(base, drives([(key, values)]))
    assert found.findings, found.summary
    assert {found.findings[0].effect, *found.findings[0].group} & {key, *alike}, found.summary


def test_a_plain_robot_misses_nothing(base: Equations) -> None:
    found = diagnose(base, drives())
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [(), (("wheel_radius:left_wheel", {"value": 0.96}),)], ids=["healthy", "a wheel"])
def test_a_simulator_that_the_logs_contradict_calibrates_nothing(hidden: Effects, base: Equations) -> None:
    """The simulator's right wheel is a tenth too large, its track too wide: that is no fault of the base."""
    wrong = [("wheel_radius:right_wheel", {"value": 1.1}), ("track_width", {"value": 1.1})]
    plant = MujocoPlant(DRIVE, [effect(key, DRIVE).inject(**values) for key, values in wrong])
    found = diagnose(base, drives(hidden), plant)
    assert [finding.effect for finding in found.findings] == [key for key, _ in hidden], found.summary
    assert CONTRADICTED in found.notes
    calibrated = diagnose(base, drives(hidden), MujocoPlant(DRIVE))
    assert [finding.effect for finding in calibrated.findings] == [key for key, _ in hidden], calibrated.summary
    assert CONTRADICTED not in calibrated.notes


@pytest.mark.slow
def test_the_whole_way_from_the_command_line(tmp_path: Path) -> None:
    main(["learn", "differential_drive", "--out", str(tmp_path / "base")])
    log = drives([("joint_friction:left_wheel", {"value": 0.03})], count=1)[0]
    added = ["joint_friction:left_wheel", "value=0.03"]
    whole_way.go(tmp_path / "base", log, "circle", added, channel="yaw", folder=tmp_path, seconds=0.6)


@pytest.mark.parametrize("late", [0.0, 0.1])
def test_wheels_whose_commands_were_swapped_are_named_beside_a_delay(late: float, base: Equations) -> None:
    data = drives([("delay", {"value": late})] if late else ())
    columns = DRIVE.layouts.action.columns
    other = dict(zip(columns, columns[::-1], strict=True))
    checked = check(base, Dataset(log.with_columns({a: log.column(b) for a, b in other.items()}) for log in data))
    assert [fault.name for fault in checked.faults] == ["left right swapped (left holds right, right holds left)"]
    np.testing.assert_array_equal(checked.data[0].action, data[0].action)


def test_what_does_not_apply_is_refused_in_words(base: Equations) -> None:
    for key in ("understeer", "wheelbase", "tyre_slip", "lateral_slip"):
        assert effect(key, base).why_not(base) == f"{key} needs steer, which is no column or quantity here"
    assert effect("rotor_loss", base).why_not(base) == "rotor_loss is an effect of a quadrotor"


@pytest.mark.parametrize(
    ("part", "instead", "match"),
    [
        (
            '<velocity name="left" joint="left_wheel"/>',
            '<position name="left" joint="left_wheel"/>',
            "position on wheels",
        ),
        (
            ' priority="1"',
            "",
            r'drag as it .* priority="1"; the body\'s origin is the middle of the axle',
        ),
        ('condim="1"', 'condim="3"', "contacts with friction that drag as it goes ahead and as it turns"),
        (
            '<joint name="left_wheel" axis="0 1 0"/>',
            '<joint name="left_wheel" axis="1 0 0"/>',
            "contacts with friction that drag as it goes ahead",
        ),
        ('<freejoint name="root"/>', '<joint name="root" type="slide" axis="1 0 0"/>', "expected a free joint"),
    ],
)
def test_a_robot_that_does_not_roll_like_that_is_refused(part: str, instead: str, match: str, tmp_path: Path) -> None:
    file = tmp_path / "wrong.xml"
    assert part in XML
    text = XML.replace(part, instead)
    file.write_text(text if "free" in text.partition("</worldbody>")[0] else re.sub("<key .*/>", "<key/>", text))
    with pytest.raises(ModelError, match=match):
        Robot.from_mjcf(file, state=STATE).nominal()


def test_wheels_without_the_state_of_the_plane_are_told_which_it_is() -> None:
    with pytest.raises(ModelError, match="on wheels it opens with --state x y sin_yaw cos_yaw vx vy wz"):
        Robot.from_mjcf(DRIVE.description.mjcf).nominal()


def test_a_heading_beside_other_columns_is_refused() -> None:
    with pytest.raises(ModelError, match="of a robot in a plane, found x, sin_yaw"):
        Robot.from_mjcf(DRIVE.description.mjcf, state=["x", "sin_yaw"])
