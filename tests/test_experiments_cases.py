"""Case files of the study: every one builds, a bad one is one clear error. What no effect covers is MuJoCo's own."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from sym2real.errors import DataError, UnknownNameError
from sym2real.experiments.study.case import Case, load_suite, shipped_suites
from sym2real.experiments.study.mechanisms import latency, speed_loop_windup, swinging_payload
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

CASES = [case for name in shipped_suites() for case in load_suite(name).cases]
NOTHING = np.random.default_rng(0)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_target_is_its_robot_with_a_difference(case: Case) -> None:
    """Its columns are the robot's, and the same commands lead elsewhere unless only the task is new."""
    robot, target, plain = case.of_robot, case.plant(1), MujocoPlant(case.of_robot)
    start = case.of_task().start(np.random.default_rng(0))
    command = 0.3 * robot.low + 0.7 * robot.high
    for plant in (target, plain):
        plant.reset(start)
        for action in (robot.rest, command, command, command, command, command):
            plant.step(action)
    assert target.layouts == robot.layouts and np.isfinite(target.true_state).all()
    moved = np.abs(target.true_state - plain.true_state).max()
    assert (moved > 1e-6) == bool(case.effects or case.mechanisms)


def test_the_nine_shifts_of_the_paper_are_there() -> None:
    cases = {case.name: case for case in load_suite("sim2sim").cases}
    assert len(cases) == 9
    masses = [MujocoPlant(CRAZYFLIE).mj_model.body_mass[1]]
    masses += [cases[name].plant(0).mj_model.body_mass[1] for name in ("mass-11", "mass-26")]
    np.testing.assert_allclose(np.array(masses[1:]) / masses[0] - 1, [0.111, 0.259], atol=5e-4)
    assert [case.name for case in cases.values() if not case.effects] == ["fast-track", "reverse-circle"]


def test_a_target_has_the_noise_of_its_seed() -> None:
    case = next(case for case in CASES if case.name == "car-plain")
    measured = [case.plant(seed).reset() for seed in (1, 1, 2)]
    np.testing.assert_array_equal(measured[0], measured[1])
    assert not np.array_equal(measured[0], measured[2])


GOOD = """\
title = "mine"
contestants = ["sr-nn"]
[[case]]
name = "one"
title = "one"
robot = "crazyflie"
task = "circle"
"""
BAD = {
    "no TOML": ("[[case", "cases in TOML"),
    "no title": (GOOD.replace('title = "mine"\n', ""), "no title"),
    "no case": ('title = "mine"\ncontestants = []\ncase = 3\n', "case to be a list, found 3"),
    "an empty list": ('title = "mine"\ncontestants = []\ncase = []\n', "case to be a list of length >= 1"),
    "contestant": (GOOD.replace('"sr-nn"', '"sr-mm"'), "did you mean.*'sr-nn'"),
    "strange field": (GOOD + 'wind = 3\n', "unknown field 'wind'"),
    "robot": (GOOD.replace("crazyflie", "crazyfly"), "case 'one'.*did you mean 'crazyflie'"),
    "task": (GOOD.replace('"circle"', '"park"'), "case 'one'.*needs a robot with the field 'heading'"),
    "option": (GOOD + "options = { size = 3 }\n", "case 'one'.*size"),
    "words for a place": (GOOD.replace('"circle"', '"hover"') + 'options = { goal = ["a", "b", "c"] }\n', "case 'one'"),
    "a list for columns": (GOOD.replace('"circle"', '"regulate"') + "options = { goal = [1] }\n", "case 'one'"),
    "effect": (GOOD + 'effects = [{ effect = "winds", fx = 0.1 }]\n', "case 'one'.*did you mean 'wind'"),
    "parameter": (GOOD + 'effects = [{ effect = "wind", fw = 0.1 }]\n', "case 'one'.*fw"),
    "no number": (GOOD + 'effects = [{ effect = "wind", fx = true }]\n', "effects to be a number, found .*True"),
    "a number without end": (
        GOOD + f'effects = [{{ effect = "wind", fx = 1{"0" * 400} }}]\n', "to be a finite number, found .*1000"
    ),
    "an option without end": (GOOD + f'options = {{ radius = 1{"0" * 400} }}\n', "case 'one'"),
    "too many digits": (f"title = 1{'0' * 5000}\n", "cases in TOML, found .*digits"),
    "nested without end": (f"title = {'[' * 5000}\n", "cases in TOML"),
    "no list": (GOOD + 'effects = "wind"\n', "case 'one', effects to be a list, found 'wind'"),
    "mechanism": (GOOD + 'mechanisms = [{ mechanism = "swing" }]\n', "case 'one'.*unknown mechanism 'swing'"),
    "its numbers": (
        GOOD + 'mechanisms = [{ mechanism = "latency", second = 1 }]\n', "expected the numbers value, found second"
    ),
    "below zero": (
        GOOD + 'mechanisms = [{ mechanism = "latency", value = -0.05 }]\n', "latency: expected value > 0, found -0.05"
    ),
    "its robot": (
        GOOD + 'mechanisms = [{ mechanism = "speed_loop_windup", gain = 1, torque = 1 }]\n',
        "expected a robot with the command speed, found crazyflie",
    ),
    "twice": (GOOD + GOOD[GOOD.index("[[case]]") :], "a name of its own"),
    "name": (GOOD.replace('name = "one"', 'name = "../one"'), "letters, digits and hyphens"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), BAD.values(), ids=BAD)
def test_a_bad_case_file_is_one_clear_error(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(DataError, match=f"mine.toml.*{said}") as raised:
        load_suite(str(file))
    assert "\n" not in str(raised.value)


def test_what_is_no_case_file_is_said(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(GOOD)
    assert load_suite(str(file)).cases[0].name == "one"
    with pytest.raises(UnknownNameError, match="did you mean 'sim2sim'"):
        load_suite("sim2simm")
    with pytest.raises(DataError, match="No such file"):
        load_suite(str(tmp_path / "none.toml"))


def swung(mass: float, length: float, thrust: float, steps: int) -> tuple[MujocoPlant, Array]:
    """The plant and the payload's angle about y by control period, from a push of the payload, with level commands."""
    plant = MujocoPlant(CRAZYFLIE, [swinging_payload(CRAZYFLIE, NOTHING, mass, length)])
    start = CRAZYFLIE.start.copy()
    start[2] = 20.0
    plant.reset(start)
    plant.mj_model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    plant.mj_data.qvel[7] = 0.2
    mujoco.mj_forward(plant.mj_model, plant.mj_data)
    angles = []
    for _ in range(steps):
        plant.step([thrust, 0.0, 0.0, 0.0])
        w, y = plant.mj_data.qpos[[7, 9]]
        angles.append(2 * np.arctan2(y, w))
    return plant, np.array(angles)


def test_a_payload_swings_as_a_pendulum_below_a_free_body() -> None:
    """Small swings below a level body of mass M: ω² = (g/l)(1 + m/M), which the weight's own inertia hardly lowers."""
    mass, length = 0.003, 0.1
    weight = (CRAZYFLIE.mass + mass) * GRAVITY
    _, angles = swung(mass, length, weight, 150)
    crossings = np.flatnonzero(np.diff(np.sign(angles)))
    between = crossings + angles[crossings] / (angles[crossings] - angles[crossings + 1])
    period = 2 * CRAZYFLIE.dt * np.diff(between).mean()
    expected = np.sqrt(GRAVITY / length * (1 + mass / CRAZYFLIE.mass) / (1 + 0.4 * 0.1**2))
    assert 2 * np.pi / period == pytest.approx(expected, rel=0.01)
    assert np.abs(angles).max() > 0.01


def test_a_swinging_payload_keeps_energy_without_thrust() -> None:
    plant, _ = swung(0.003, 0.1, 0.0, 1)
    before = plant.mj_data.energy.sum()
    kinetic = plant.mj_data.energy[1]
    for _ in range(40):
        plant.mj_data.ctrl[:] = 0.0
        plant.mj_model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
        mujoco.mj_step(plant.mj_model, plant.mj_data)
    mujoco.mj_forward(plant.mj_model, plant.mj_data)
    assert plant.mj_data.energy.sum() == pytest.approx(before, rel=1e-6)
    assert plant.mj_data.energy[1] > 2 * kinetic > 0


def speeds(gain: float, torque: float) -> tuple[Array, float]:
    """Speed of the car by control period after a step of the command to 1.5 m/s, and the largest stored angle."""
    plant = MujocoPlant(MUSHR, [speed_loop_windup(MUSHR, NOTHING, gain, torque)])
    plant.reset()
    reached, stored = [], 0.0
    for _ in range(60):
        reached.append(plant.step([0.0, 1.5])[4])
        rolled = plant.mj_data.qpos[[8, 10, 11, 12]]  # spin joints behind the free joint's seven
        stored = max(stored, float((plant.mj_data.act - rolled).max()))
    return np.array(reached), stored


def test_a_speed_loop_winds_up_only_where_the_motor_gives_all_it_can() -> None:
    """The integral that a limited motor leaves behind drives the car past its command; in the end it reaches it."""
    limited, much = speeds(0.09, 0.07)
    free, little = speeds(0.09, 10.0)
    assert limited.max() > 1.15 * 1.5 > free.max()
    assert much > 2 * little
    for reached in (limited, free):
        assert reached[-1] == pytest.approx(1.5, rel=0.02)


def test_latency_is_a_late_command() -> None:
    late, plain = MujocoPlant(MUSHR, [latency(MUSHR, NOTHING, 0.2)]), MujocoPlant(MUSHR)
    commands = [[0.0, 0.0], *[[0.1, 1.0]] * 15]
    moved = [np.array([plant.step(command)[4] for command in commands]) for plant in (late, plain)]
    np.testing.assert_allclose(moved[0][4:], moved[1][:-4], atol=2e-3)
    assert np.abs(moved[0][:4]).max() < 1e-6
    assert moved[1][3] > 0.1
