"""A rotorcraft of a user's own, from its MJCF alone: equations, what is refused, and the way to a finding."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import torch
from effects_cases import Run, change, predicted, simulated, wander

from sym2real.cli import main
from sym2real.diagnosis import try_effect
from sym2real.effects import applicable, effect
from sym2real.errors import ModelError
from sym2real.experiments.noisy_runs import noisy_runs
from sym2real.plants import MujocoPlant
from sym2real.robots import ROBOTS, Robot
from sym2real.symbolic import compile_model, load_model
from sym2real.tasks import make_task

# Front rotors stand wider than those behind, on arms that are bodies of their own; the battery hangs below.
MJCF = """
<mujoco model="wide">
  <option timestep="0.002" integrator="RK4"/>
  <default>
    <geom contype="0" conaffinity="0"/>
    <motor ctrlrange="0 1" ctrllimited="true"/>
  </default>
  <worldbody>
    <body name="frame" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.09 0.06 0.03" mass="1.1"/>
      <geom type="box" size="0.06 0.02 0.01" pos="0 0 -0.04" mass="0.2"/>
      <body pos="0.13 -0.22 0.02"><geom type="sphere" size="0.02" mass="0.05"/><site name="s1"/></body>
      <body pos="-0.13 -0.2 0.02"><geom type="sphere" size="0.02" mass="0.05"/><site name="s2"/></body>
      <body pos="-0.13 0.2 0.02"><geom type="sphere" size="0.02" mass="0.05"/><site name="s3"/></body>
      <body pos="0.13 0.22 0.02"><geom type="sphere" size="0.02" mass="0.05"/><site name="s4"/></body>
    </body>
  </worldbody>
  <actuator>
    <motor name="motor1" site="s1" gear="0 0 8 0 0 -0.13"/>
    <motor name="motor2" site="s2" gear="0 0 8 0 0 0.13"/>
    <motor name="motor3" site="s3" gear="0 0 8 0 0 -0.13"/>
    <motor name="motor4" site="s4" gear="0 0 8 0 0 0.13"/>
  </actuator>
  <keyframe><key qpos="0 0 1 1 0 0 0" ctrl="0.46 0.46 0.46 0.46"/></keyframe>
</mujoco>
"""


def test_equations_are_the_simulator() -> None:
    robot, rng = Robot.from_mjcf(MJCF, name="wide"), np.random.default_rng(0)
    assert robot.recipe.base == "nominal"
    assert robot.numbers["arm"] == pytest.approx(np.hypot([0.13] * 2, [0.22, 0.2]).mean())
    model, plant = compile_model(robot.nominal(), dtype=torch.float64), MujocoPlant(robot)
    for _ in range(5):
        state, action = robot.start.copy(), robot.rest + rng.uniform(-0.1, 0.1, 4)
        state[7:] = rng.uniform(-0.5, 0.5, 6)
        plant.reset(state)
        after = plant.step(action)
        found = model(*map(torch.as_tensor, (state, action, np.zeros(6)))).numpy()
        assert np.abs(found - after).max() < 5e-3 * np.abs(after - state).max()


@pytest.mark.parametrize(
    ("part", "instead", "match"),
    [
        ('name="motor1"', 'name="front"', r"not called motor1, motor2, .* \(`--actions ACTUATOR=motor1 …`"),
        ('gear="0 0 8 0 0 0.13"', 'gear="0 0 7 0 0 0.13"', "rotors that do not push alike"),
        ('gear="0 0 8 0 0 0.13"', 'gear="0 0 8 0 0 0.3"', "rotors whose torques are not alike"),
        ('pos="0 0 -0.04" mass="0.2"', 'pos="0.1 0 -0.04" mass="0.2"', "m from the body's origin"),
        ('pos="0 0 -0.04" mass="0.2"', 'pos="0 0 -0.04" euler="0 0 30" mass="0.2"', "principal axes"),
        ('integrator="RK4"', 'integrator="RK4" gravity="0 0 -3.7"', "a gravity that is not 9.81"),
        ('integrator="RK4"/>', 'integrator="RK4"><flag gravity="disable"/></option>', "a gravity that is not 9.81"),
        ('ctrlrange="0 1"', 'ctrlrange="0 1" forcerange="0 0.5"', "rotors whose force ends before"),
        ("<freejoint/>", '<joint type="free" damping="0.5"/>', "a damping of the free joint"),
        ('name="frame"', 'name="frame" gravcomp="1"', "a compensation of gravity"),
        ("<freejoint/>", '<joint name="up" type="slide" axis="0 0 1"/>', "an actuator with a filter, or on no joint"),
    ],
)
def test_what_these_equations_do_not_cover_is_refused(part: str, instead: str, match: str) -> None:
    assert part in MJCF
    text = MJCF.replace(part, instead)
    with pytest.raises(ModelError, match=match):
        Robot.from_mjcf(text if "free" in text else text.replace("0 0 1 1 0 0 0", "0"), name="wide").nominal()


EFFECTS = {
    "added_mass": {"value": 0.2},
    "payload": {"mass": 0.1, "rx": 0.02, "ry": -0.03},
    "com_offset": {"rx": 0.003, "ry": -0.002},
    "battery_sag": {"value": 0.4},
    "ground_effect": {"value": 2.0},
    "translational_lift": {"value": 0.3},
    "thrust_curve": {"value": 2.0},
    "gain:thrust": {"value": 0.8},
    "offset:thrust": {"value": 1.5},
    "rotor_loss": {"rotor": 2, "value": 0.2},
    "torque_scale": {"kx": 0.7, "ky": 1.3, "kz": 2.0},
    "motor_lag": {"value": 0.05},
    "rate_damping": {"dx": 0.02, "dy": 0.01, "dz": 0.02},
    "wind": {"fx": 2.0, "fy": -1.0},
    "linear_drag": {"cx": 0.5, "cy": 0.8, "cz": 0.2},
    "mounting_tilt": {"roll": 0.05, "pitch": -0.03},
}


@pytest.fixture(scope="module")
def in_a_scene() -> Robot:
    """It hovers over a box, which stands before it in the file and is none of its mass."""
    box = '<body name="box" pos="1 0 -1"><geom type="box" size="0.3 0.3 0.3"/></body><body name="frame" '
    return Robot.from_mjcf(MJCF.replace('<body name="frame" ', box), name="wide")


def test_every_effect_of_its_equations_can_be_simulated(in_a_scene: Robot) -> None:
    assert in_a_scene.mass == pytest.approx(1.5)
    keys = {found.key for found in applicable(in_a_scene.nominal())}
    assert keys >= set(EFFECTS)
    assert {key: reason for key in keys if (reason := effect(key, in_a_scene).why_not(in_a_scene))} == {}


@pytest.mark.parametrize("key", EFFECTS)
def test_an_effect_in_the_equations_is_the_effect_in_the_simulator(key: str, in_a_scene: Robot) -> None:
    """Rotors on bodies of their own, with gears of 8, answer commands that turn the body."""
    rng, robot, base = np.random.default_rng(2), in_a_scene, in_a_scene.nominal()
    starts = np.repeat(robot.start[None], 3, axis=0)
    starts[:, 2], starts[:, 7:] = 0.3, rng.uniform(-0.8, 0.8, (3, 6))
    actions = np.array([robot.rest + wander(rng, 12, [0.03] * 4, 6.0) for _ in starts])
    given, values = Run(robot, starts, actions), EFFECTS[key]
    truth = change(robot, simulated(given, [effect(key, robot).inject(**values)]), simulated(given, []))
    found = change(robot, predicted(effect(key, base).substitute(base, values), given), predicted(base, given))
    for field, columns in (("position and velocity", [0, 1, 2, 6, 7, 8]), ("attitude and rates", [3, 4, 5, 9, 10, 11])):
        seen, expected = truth[..., columns], found[..., columns]
        if np.linalg.norm(seen) > 1.0 or np.linalg.norm(expected) > 1.0:
            assert np.linalg.norm(seen - expected) < 0.1 * np.linalg.norm(seen), field


def test_rotors_that_differ_by_far_bend_each_by_itself(in_a_scene: Robot) -> None:
    """Of commands from a tenth of the hover's to twice it, four thrusts that bend are not the sum's that does."""
    rng, robot, base = np.random.default_rng(4), in_a_scene, in_a_scene.nominal()
    starts = np.repeat(robot.start[None], 3, axis=0)
    starts[:, 2] = 0.3
    given = Run(robot, starts, robot.rest * rng.uniform(0.1, 1.9, (3, 4, 4)))
    bent = effect("thrust_curve", robot)
    truth = change(robot, simulated(given, [bent.inject(value=1.4)]), simulated(given, []))
    found = change(robot, predicted(bent.substitute(base, {"value": 1.4}), given), predicted(base, given))
    assert np.linalg.norm(found - truth) < 0.05 * np.linalg.norm(truth)


def test_one_command_makes_a_model_that_knows_its_robot(tmp_path: Path) -> None:
    (tmp_path / "wide.xml").write_text(MJCF)
    main(["nominal", "mjcf", str(tmp_path / "wide.xml"), "--out", str(tmp_path / "wide")])
    known = load_model(tmp_path / "wide")
    assert known.layouts.action.columns == ("motor1", "motor2", "motor3", "motor4")
    main(["simulate", str(tmp_path / "wide"), "hover", "--seconds", "0.4", "--out", str(tmp_path / "log.csv")])


@pytest.mark.slow
def test_what_takes_half_a_second_to_show_is_seen_in_fast_logs() -> None:
    """At 100 Hz as at 50: noise hides what a drag does in a quarter of a second, 0.3 % of the squares."""
    robot = Robot.from_mjcf(ROBOTS["hexarotor"].description.mjcf, name="fast", dt=0.01)
    tasks = [make_task(name, robot) for name in ("circle", "lemniscate")]
    drag = {"cx": 0.05, "cy": 0.05, "cz": 0.05}
    logs = noisy_runs(robot, tasks, [("linear_drag", drag)], count=4, rows=1000, seed=5)
    tried = try_effect(robot.nominal(), "linear_drag", logs, exclude=["*"])
    assert tried.gain > 0.015
    assert tried.finding.values["cx"] == pytest.approx(0.05, rel=0.2)


def test_motors_that_the_file_calls_otherwise_have_their_columns_names() -> None:
    renamed = MJCF
    for number in range(1, 5):
        renamed = renamed.replace(f'name="motor{number}"', f'name="esc_{number}"')
    actions = {f"esc_{number}": f"motor{number}" for number in range(1, 5)}
    robot = Robot.from_mjcf(renamed, name="renamed", actions=actions)
    assert robot.nominal().next == Robot.from_mjcf(MJCF, name="own").nominal().next


def test_rotors_of_a_file_without_a_keyframe_hover_at_rest() -> None:
    """At rest without thrust nothing could hold it, and a diagnosis ended there."""
    text = re.sub(r"<keyframe>.*</keyframe>", "", MJCF, flags=re.DOTALL)
    robot = Robot.from_mjcf(text, name="bare")
    plant = MujocoPlant(robot)
    start, after = plant.reset(), plant.step(robot.rest)
    height = robot.layouts.state.index("vz")
    assert abs(after[height] - start[height]) < 1e-6 * 9.81 * robot.dt
