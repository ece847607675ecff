"""Any MJCF is a robot: columns by its joints, equations by its bodies, and the whole way with a cart-pole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
import whole_way

from sym2real.adaptation import StageOne
from sym2real.cli import main
from sym2real.control import geometric_controller
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare, diagnose, try_effect
from sym2real.diagnosis.estimate.simulator import flown_along
from sym2real.effects import applicable, effect
from sym2real.effects.body import Body
from sym2real.errors import DataError, ModelError, ShapeError, UnknownNameError
from sym2real.experiments.learning import learn_in_simulation
from sym2real.experiments.models import open_model
from sym2real.experiments.noisy_runs import Effects, noisy_runs
from sym2real.experiments.standard_conditions import sensors
from sym2real.logs import read_log
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import ROBOTS, Robot
from sym2real.robots.mjcf_columns import inertias, opened
from sym2real.robots.multibody import MOST_PARTS
from sym2real.symbolic import Equations, compile_model, load_model, save_model
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

CART_POLE = ROBOTS["cart_pole"]
ARM = """
<mujoco model="arm">
  <option timestep="0.001" gravity="0 0 -9.81" integrator="RK4"/>
  <worldbody>
    <body name="base" pos="0.1 0 0.2" euler="0 0 30">
      <joint name="waist" axis="0 0 1" damping="0.02" armature="0.01"/>
      <joint name="shoulder" axis="0 1 0" pos="0 0 0.05" stiffness="0.4" springref="10"/>
      <inertial pos="0.02 0.01 0.2" quat="0.9 0.1 0.3 0.2" mass="1.1" diaginertia="0.02 0.03 0.025"/>
      <body name="fore" pos="0 0.02 0.4" quat="0.8 0.2 0 0.3">
        <joint name="reach" type="slide" axis="0.6 0 0.8" range="-0.5 0.5"/>
        <inertial pos="0 0.03 0.1" mass="0.6" diaginertia="0.004 0.005 0.003"/>
        <body name="tool" pos="0 0 0.2"><inertial pos="0.01 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/></body>
        <site name="grip" pos="0 0.01 0.25"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="to_waist" joint="waist" kp="8" kv="0.5" ctrlrange="-2 2"/>
    <motor name="lift" joint="shoulder" gear="3" ctrlrange="-5 5" forcerange="-2 2"/>
    <velocity name="pull" joint="reach" kv="6" ctrlrange="-1 1"/>
  </actuator>
</mujoco>
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    file = tmp_path_factory.mktemp("arm") / "arm.xml"
    file.write_text(ARM)
    return Robot.from_mjcf(file, dt=0.005)  # its waist is a stiff servo


@pytest.fixture(scope="module")
def equations(arm: Robot) -> dict[str, Equations]:
    return {"arm": arm.nominal(), "cart_pole": CART_POLE.nominal()}


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one base of the cart-pole that these tests learn."""
    folder = tmp_path_factory.mktemp("cart_pole")
    settings = StageOne(2, 120, samples=64, until_settled=False)
    learn_in_simulation(CART_POLE, "beam", settings, None, lambda _: None).save(folder)
    return folder


def to_and_fro(effects: Effects = (), count: int = 4, rows: int = 300) -> Dataset:
    """Noisy runs of the cart-pole between two places."""
    tasks = [make_task("regulate", CART_POLE, goal={"slider": place}) for place in (0.3, -0.3)]
    return noisy_runs(CART_POLE, tasks, effects, count=count, rows=rows, dither=2.5, seed=7)


def drawn(robot: Robot, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """A state, an action and a push that the robot may meet."""
    state = robot.start + rng.uniform(-0.4, 0.4, robot.start.shape)
    action = rng.uniform(robot.low, robot.high)
    push = [rng.uniform(-1.0, 1.0) * robot.limits.push[column] for column in robot.layouts.inputs]
    return state, action, np.array(push)


def misses(robot: Robot, equations: Equations, plant: MujocoPlant, told: float = 1.0) -> tuple[Array, Array]:
    """What the equations miss, and how far the simulator moves, root mean square over ten draws of one step.

    Commands and pushes use so much of their range.
    """
    rng, missed, moved = np.random.default_rng(3), [], []
    model = compile_model(equations, dtype=torch.float64)
    for _ in range(10):
        state, action, push = drawn(robot, rng)
        action, push = robot.rest + told * (action - robot.rest), told * push
        plant.reset(state)
        plant.push(push)
        after = plant.step(action)
        missed.append(model(*map(torch.as_tensor, (state, action, push))).numpy() - after)
        moved.append(after - state)
    return np.sqrt(np.square(missed).mean(0)), np.sqrt(np.square(moved).mean(0))


def test_columns_limits_and_units_are_those_of_the_file(arm: Robot) -> None:
    state, action = arm.layouts.state, arm.layouts.action
    assert set(state.joints) == {"waist", "shoulder", "reach"}
    assert {one: state.units[one] for one in state} == {
        "waist": "rad", "shoulder": "rad", "reach": "m", "waist_rate": "rad/s", "shoulder_rate": "rad/s",
        "reach_rate": "m/s",
    }  # fmt: skip
    assert action.units == {"to_waist": "rad", "lift": "N m", "pull": "m/s"}
    assert arm.layouts.inputs.units == {"waist_push": "N m", "shoulder_push": "N m", "reach_push": "N"}
    np.testing.assert_array_equal(arm.high, [2.0, 5.0, 1.0])
    assert arm.mass == pytest.approx(1.8)
    assert arm.substeps == 5
    assert Robot.from_mjcf(arm.description.mjcf).dt == pytest.approx(0.02)


def test_a_reset_to_any_state_is_that_state(arm: Robot) -> None:
    rng, plant = np.random.default_rng(0), MujocoPlant(arm)
    for _ in range(3):
        state = rng.normal(size=arm.layouts.state.size)
        np.testing.assert_allclose(plant.reset(state), state, atol=1e-14)


def test_columns_may_be_chosen_and_actions_named(arm: Robot) -> None:
    chosen = Robot.from_mjcf(arm.description.mjcf, actions={"lift": "torque"}, state=["shoulder", "shoulder_rate"])
    assert chosen.layouts.action.columns == ("torque",)
    assert chosen.layouts.state.columns == ("shoulder", "shoulder_rate")
    np.testing.assert_array_equal(chosen.description.to_control(np.array([2.0])), [0.0, 2.0, 0.0])
    with pytest.raises(ModelError, match="no waist"):
        chosen.nominal()


def test_actuators_that_are_no_action_hold_their_joints_at_control_zero(arm: Robot) -> None:
    """A stiff servo beside the commanded ones: without it a step would be another."""
    chosen = Robot.from_mjcf(arm.description.mjcf, actions=["lift"], dt=arm.dt)
    missed, moved = misses(chosen, chosen.nominal(), MujocoPlant(chosen))
    assert (missed < 1e-3 * moved).all()


@pytest.mark.parametrize("name", ["arm", "cart_pole"])
def test_equations_of_a_file_are_its_simulator(name: str, arm: Robot, equations: dict[str, Equations]) -> None:
    """Oblique axes, springs, gears, several joints of one body: a step is MuJoCo's but for the step's own error."""
    robot = {"arm": arm, "cart_pole": CART_POLE}[name]
    missed, moved = misses(robot, equations[name], MujocoPlant(robot))
    assert (missed < 3e-3 * moved).all(), missed / moved


FOLDING = """
<mujoco model="turret">
  <worldbody>
    <body>
      <joint name="pan" axis="0 0 1"/>
      <geom type="cylinder" size="0.05 0.05" mass="1" contype="0" conaffinity="0"/>
      <body><joint name="tilt" axis="0 -1 0" range="-80 80" limited="true"/>
        <geom type="capsule" fromto="0 0 0 0.6 0 0" size="0.03" mass="2" contype="0" conaffinity="0"/></body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="turn" joint="pan" kv="5" ctrlrange="-2 2"/>
    <motor name="lift" joint="tilt" ctrlrange="-20 20"/>
  </actuator>
</mujoco>
"""


@pytest.mark.slow
def test_a_joint_that_is_hardly_there_in_some_pose_makes_no_endless_equations() -> None:
    """A ball on a slide that may stand on the axis that a servo turns: it would take dozens of steps in a period."""
    light = """
    <mujoco><worldbody><body><joint name="turn" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1e-4 1e-4 1e-4"/>
      <body><joint name="out" type="slide" axis="1 0 0" range="0 0.5" limited="true"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1e-4 1e-4 1e-4"/></body></body></worldbody>
      <actuator><velocity name="servo" joint="turn" kv="5" ctrlrange="-2 2"/></actuator>
      <keyframe><key qpos="0 0.4"/></keyframe></mujoco>"""
    equations = Robot.from_mjcf(light, name="light").nominal()
    assert any("rests within a small part of a period" in note for note in equations.notes)
    parts = {name.partition("_")[0] for name in equations.quantities if name.startswith("part")}
    assert parts == {f"part{number}" for number in range(2, MOST_PARTS + 1)}


def test_equations_that_are_long_say_why_and_tell_how_far_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "stiff.xml").write_text("""
    <mujoco><worldbody><body><joint name="slow" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <body><joint name="light" axis="1 0 0"/><inertial pos="0 0 0" mass="1" diaginertia="1e-3 1e-3 1e-3"/></body>
    </body></worldbody>
      <actuator><velocity name="servo" joint="light" kv="1" ctrlrange="-2 2"/></actuator></mujoco>""")
    main(["nominal", "mjcf", str(tmp_path / "stiff.xml"), "--dt", "0.02", "--out", str(tmp_path / "stiff")])
    said = capsys.readouterr()
    assert "a period takes 15 steps" in " ".join(said.out.split())
    assert "light is so light beside what brakes it that it rests within 0.001 s" in " ".join(said.out.split())
    assert "deriving the equations of 2 joints: step 1 of 15 in a period" in " ".join(said.err.split())


def regulated(robot: Robot, hidden: str, value: float, count: int) -> list[Trajectory]:
    """Noisy runs to where the task begins, and rest there for nearly all of the time."""
    task, logs = make_task("regulate", robot), []
    for seed in range(count):
        noise = sensors(robot, np.random.default_rng(seed).spawn(1)[0])
        plant = MujocoPlant(robot, [noise, effect(hidden, robot).inject(value=value)])
        controller = geometric_controller(robot, task.reference)
        logs.append(run_episode(plant, controller, task, seed=seed, name=f"run{seed}"))
    return logs


@pytest.mark.slow
def test_a_hidden_effect_that_a_second_of_two_logs_shows_is_named_and_not_established() -> None:
    robot = Robot.from_mjcf(FOLDING)
    base, logs, simulator = robot.nominal(), regulated(robot, "joint_damping:tilt", 4.0, 2), MujocoPlant(robot)
    found = diagnose(base, logs, simulator)
    assert found.verdict == "CANNOT_TELL"
    assert not found.findings
    assert found.suspects["joint_damping:tilt"] > 0.9
    assert "joint_damping:tilt" in found.summary.partition(" would explain ")[0]
    tried = try_effect(base, "joint_damping:tilt", logs, simulator, exclude=["*"])
    assert not tried.supported
    assert "too few independent pieces" in tried.summary


@pytest.mark.slow
def test_a_joint_at_its_end_is_what_ended_the_episode(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "turret.xml").write_text(FOLDING.replace('range="-80 80"', 'range="0 80"'))
    main(["nominal", "mjcf", str(tmp_path / "turret.xml"), "--out", str(tmp_path / "turret")])
    main(["simulate", str(tmp_path / "turret"), "regulate", "--out", str(tmp_path / "log.csv")])
    assert "tilt at the end of its range" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("speed", [0.004, 0.012, 0.02, 0.1])
def test_dry_friction_stops_a_slide_within_a_period(tmp_path: Path, speed: float) -> None:
    """By Coulomb's law: where that was soft, a fit made all of a cart-pole's masses and forces three times as small."""
    part = '<joint name="rail" type="slide" axis="1 0 0" frictionloss="0.8"/><geom size="0.1" mass="1"/>'
    motor = '<motor name="drive" joint="rail" ctrlrange="-5 5"/>'
    file = tmp_path / "rail.xml"
    file.write_text(f"<mujoco><worldbody><body>{part}</body></worldbody><actuator>{motor}</actuator></mujoco>")
    place, rate = Robot.from_mjcf(file, dt=0.02).nominal().predict([0.0, speed], [0.0])
    moving = min(0.02, speed / 0.8)
    assert rate == pytest.approx(speed - 0.8 * moving, abs=0.04 * speed)
    assert place == pytest.approx(speed * moving - 0.4 * moving**2, abs=5e-6)


def test_a_command_on_a_slide_behind_a_gear_is_no_force() -> None:
    geared = ARM.replace('<velocity name="pull" joint="reach" kv="6"', '<motor name="pull" joint="reach" gear="20"')
    direct = geared.replace('gear="20"', "")
    units = [Robot.from_mjcf(text, name="arm", dt=0.005).layouts.action.units["pull"] for text in (geared, direct)]
    assert units == ["1", "N"]


def test_equations_follow_a_servo_in_whatever_pose_the_joint_it_turns_weighs_least() -> None:
    """Raised to its end the barrel has a twentieth of its inertia about the first joint, and that rests sooner."""
    robot = Robot.from_mjcf(FOLDING)
    model, state = compile_model(robot.nominal(), dtype=torch.float64), np.array([0.0, 1.39, 1.0, 0.0])
    for _ in range(10):
        state = model(torch.as_tensor(state), torch.zeros(2), torch.zeros(2)).numpy()
        assert abs(state[2]) < 1.0
    assert abs(state[2]) < 1e-3


SERVO = '<position name="to_waist" joint="waist" kp="8" kv="0.5" ctrlrange="-2 2"/>'


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "instead"),
    [
        ('axis="0 0 1" damping', 'ref="40" axis="0 0 1" damping'),
        ('springref="10"', 'springref="10" ref="-20"'),
        ('range="-0.5 0.5"', 'range="0.3 1.3" ref="0.8"'),
        ('integrator="RK4"/>', 'integrator="RK4"><flag gravity="disable"/></option>'),
        ('integrator="RK4"/>', 'integrator="RK4"><flag spring="disable" damper="disable"/></option>'),
        ('axis="0 1 0"', 'axis="0 1 0" actuatorfrcrange="-2 3"'),
        (SERVO, '<general name="to_waist" joint="waist" gainprm="8" biasprm="1 -8 -0.5" ctrlrange="-2 2"/>'),
        (SERVO, '<position name="to_waist" joint="waist" kp="0.8" gear="-3" ctrlrange="-2 2"/>'),
    ],
)
def test_what_a_file_says_of_zeros_ends_and_what_is_off_is_in_its_equations(part: str, instead: str) -> None:
    """``ref`` of a joint, flags, a joint's largest force, and a bias without a type, which MuJoCo does not read."""
    assert part in ARM
    robot = Robot.from_mjcf(ARM.replace(part, instead), name="arm", dt=0.005)
    missed, moved = misses(robot, robot.nominal(), MujocoPlant(robot))
    assert (missed < 3e-3 * moved).all(), missed / moved


@pytest.mark.parametrize(
    ("part", "instead", "match"),
    [
        ('<body name="fore"', '<body name="fore" gravcomp="1"', "a compensation of gravity"),
        ('integrator="RK4"', 'integrator="RK4" density="1000"', "a liquid around it"),
        ('integrator="RK4"/>', 'integrator="RK4"><flag actuation="disable"/></option>', "switched off"),
        (SERVO, SERVO.replace("/>", ' delay="0.02" nsample="30"/>'), "an actuator with a delay"),
        (SERVO, '<damper name="to_waist" joint="waist" kv="3" ctrlrange="0 1"/>', "gain depends on where it is"),
        ('damping="0.02"', 'damping="0.02 0.1 0.1"', "dampers that are not linear"),
    ],
)
def test_what_pushes_and_is_in_no_equations_is_refused_by_its_name(part: str, instead: str, match: str) -> None:
    assert part in ARM
    robot = Robot.from_mjcf(ARM.replace(part, instead), name="arm")
    assert robot.recipe.base == "episodes"
    with pytest.raises(ModelError, match=match):
        robot.nominal()


def test_a_servo_with_a_gear_reaches_the_ends_of_its_joint() -> None:
    """It compares its control with the joint's place times the gear; of a motor that pushes backwards ends change."""
    servos = {
        (-3.0, 3.0): '<position name="to_waist" joint="waist" kp="8" gear="-3"/>',
        (-2.0, 2.0): '<position name="to_waist" joint="waist" kp="8" gear="3" ctrlrange="-2 2"/>',
        (-0.5, 0.25): '<general name="to_waist" joint="waist" gainprm="-2" forcerange="-0.5 1"/>',
    }
    text = ARM.replace('<joint name="waist"', '<joint name="waist" range="-57.29578 57.29578"')
    for ends, servo in servos.items():
        robot = Robot.from_mjcf(text.replace(SERVO, servo), name="arm")
        assert (robot.low[0], robot.high[0]) == pytest.approx(ends)


@pytest.mark.parametrize(
    ("name", "key", "values"),
    [
        ("arm", "joint_damping:shoulder", {"value": 0.5}),
        ("arm", "joint_damping:waist", {"value": -0.5}),  # less than its servo's own
        ("arm", "joint_stiffness:shoulder", {"value": 5.0}),
        ("arm", "joint_stiffness:shoulder", {"value": -0.4}),
        ("arm", "joint_drag:shoulder", {"value": 0.2}),
        ("arm", "joint_bias:shoulder", {"value": 1.0}),
        ("arm", "torque_ripple:shoulder", {"count": 7.0, "sine": 0.5, "cosine": -0.3}),
        ("arm", "armature:shoulder", {"value": 0.1}),
        ("arm", "link_mass:reach", {"value": 1.5}),
        ("arm", "link_mass:shoulder", {"value": 0.7}),
        ("arm", "link_centre:shoulder", {"value": 1.4}),
        ("arm", "link_inertia:shoulder", {"value": 2.0}),
        ("arm", "link_length:shoulder", {"value": 1.3}),
        ("arm", "servo_gain:waist", {"value": 0.6}),
        ("arm", "servo_limit:waist", {"value": 2.0}),
        ("arm", "gravity_tilt", {"roll": 0.2, "pitch": -0.1}),
        ("arm", "load:grip", {"value": 0.4}),
        ("arm", "gain:pull", {"value": 0.6}),
        ("cart_pole", "joint_friction:slider", {"value": 1.0}),
        ("cart_pole", "stribeck:slider", {"value": 1.0, "speed": 0.5}),
    ],
)
def test_an_effect_in_the_equations_is_the_effect_in_the_simulator(
    name: str, key: str, values: dict[str, float], arm: Robot, equations: dict[str, Equations]
) -> None:
    """Joint damping, drag, friction loss, stiffness, armature, gravity and bodies are MuJoCo's own, not the formulas'.

    MuJoCo's dry friction is soft: where a joint decelerates much faster than in proportion to its rate, it pushes on.
    So it is told little.
    """
    told = 0.05 if key.startswith(("joint_friction", "stribeck")) else 1.0
    robot, base = {"arm": arm, "cart_pole": CART_POLE}[name], equations[name]
    plant = MujocoPlant(robot, (effect(key, robot).inject(**values),))
    without, _ = misses(robot, base, plant, told)
    left, _ = misses(robot, effect(key, base).substitute(base, values), plant, told)
    assert np.linalg.norm(left) < 0.15 * np.linalg.norm(without)


@pytest.mark.slow
@pytest.mark.parametrize(
    "site",
    [
        '<frame pos="0.1 0 0" euler="0 30 0"><site name="grip" pos="0 0.01 0.25"/></frame>',
        '<site name="grip" type="capsule" size="0.01" fromto="0 0 0 0.1 0.2 0.3"/>',
    ],
)
def test_a_load_hangs_where_its_site_is_however_the_file_says_so(site: str) -> None:
    plain = '<site name="grip" pos="0 0.01 0.25"/>'
    assert plain in ARM
    robot = Robot.from_mjcf(ARM.replace(plain, site), name="arm", dt=0.005)
    base, load = robot.nominal(), effect("load:grip", robot)
    plant = MujocoPlant(robot, (load.inject(value=0.4),))
    without, _ = misses(robot, base, plant)
    left, _ = misses(robot, load.substitute(base, {"value": 0.4}), plant)
    assert np.linalg.norm(left) < 0.02 * np.linalg.norm(without)


def test_pushes_stand_in_for_effects_where_equations_were_learned(learned: Path) -> None:
    """Damping needs no quantity of its own: the inputs that pushed episodes taught take it."""
    base, key = load_model(learned), "joint_damping:slider"
    found = effect(key, base).substitute(base, {"value": 1.5})
    plant = MujocoPlant(CART_POLE, (effect(key, CART_POLE).inject(value=1.5),))
    (before, _), (after, _) = misses(CART_POLE, base, plant), misses(CART_POLE, found, plant)
    place = CART_POLE.layouts.state.index("slider_rate")
    assert after[place] < 0.3 * before[place]
    assert "armature:slider" not in {one.key for one in applicable(base)}
    assert effect("armature:slider", base).why_not(base) == (
        "armature:slider needs armature_slider, which is no column or quantity here"
    )


HIDDEN = [
    ("gain:drive", {"value": 0.8}, {"armature:slider"}),
    ("joint_friction:slider", {"value": 1.5}, set()),
    ("gravity_tilt", {"pitch": 0.03}, set()),
    ("lag:drive", {"value": 0.06}, {"lag"}),
    ("delay:drive", {"value": 0.04}, {"delay"}),
    ("joint_bias:pole", {"value": 0.02}, {"gravity_tilt"}),
]


@pytest.mark.parametrize(("key", "values", "alike"), HIDDEN, ids=[key for key, *_ in HIDDEN])
def test_a_hidden_effect_of_the_cart_pole_is_named(
    key: str, values: dict[str, float], alike: set[str], equations: dict[str, Equations]
) -> None:
    found = diagnose(equations["cart_pole"], to_and_fro([(key, values)], count=6))
    assert found.findings, found.summary
    first = found.findings[0]
    assert {first.effect, *first.group} & {key, *alike}, found.summary


@pytest.mark.slow
def test_less_inertia_than_described_is_found_though_predictions_of_a_pole_that_falls_are_worse_with_it(
    equations: dict[str, Equations],
) -> None:
    """A lighter pole falls faster, and so does the noise of every start: predictions say nothing, and stop nothing."""
    found = diagnose(equations["cart_pole"], to_and_fro([("armature:pole", {"value": -0.004})], count=6))
    assert (found.verdict, [one.effect for one in found.findings]) == ("EFFECT", ["armature:pole"])
    assert found.findings[0].values["value"] == pytest.approx(-0.004, rel=0.1)
    assert not found.gate.beats_hold


@pytest.mark.parametrize("robot", ["cart_pole", "arm", "differential_drive"])
def test_no_joint_may_have_less_armature_than_leaves_its_masses_positive(robot: str) -> None:
    known = ROBOTS[robot]
    model, data = opened(known.description.mjcf)
    for joint in Body.of(known).joints:
        armature = effect(f"armature:{joint}", known)
        (value,) = armature.parameters
        for part, positive in ((0.99, True), (1.01, False)):
            masses = inertias(model, data)
            masses[(place := model.joint(joint).dofadr[0]), place] += part * value.domain.low
            assert bool((np.linalg.eigvalsh(masses) > 0).all()) is positive
        assert value.low == pytest.approx(0.5 * value.domain.low)
        with pytest.raises(ModelError, match=f"armature:{joint}: expected more than -"):
            armature.inject(value=1.01 * value.domain.low)


def test_a_plain_cart_pole_misses_nothing(equations: dict[str, Equations]) -> None:
    found = diagnose(equations["cart_pole"], to_and_fro())
    assert (found.verdict, found.findings) == ("NOTHING_MISSING", ())


def test_the_whole_way_from_the_command_line(learned: Path, tmp_path: Path) -> None:
    """On a log with friction that nobody was told of."""
    log = to_and_fro([("joint_friction:slider", {"value": 1.5})], rows=400)[0]
    added = ["joint_friction:slider", "value=1.5"]
    whole_way.go(learned, log, "regulate", added, channel="joint displacement", folder=tmp_path, seconds=1.0)


def test_a_pendulum_of_ones_own_is_compared_and_diagnosed() -> None:
    """Equations from text with columns that no robot here has: an answer in words, no bare error of NumPy."""
    named = Equations.parse(
        CART_POLE.layouts,
        {
            "slider": "slider + 0.02*slider_rate",
            "pole": "pole + 0.02*pole_rate",
            "slider_rate": "slider_rate + 0.016*drive",
            "pole_rate": "pole_rate + 0.5*sin(pole) - 0.04*drive",
        },
        0.02,
    )
    data = to_and_fro(count=2, rows=200)
    assert compare(named, data).at(0.5).errors["joint angle"].unit == "rad"
    assert diagnose(named, data).verdict in {"EFFECT", "UNEXPLAINED", "CANNOT_TELL", "NOTHING_MISSING"}


def test_what_does_not_apply_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match=r"hover.*needs a robot with the field 'attitude'"):
        make_task("hover", CART_POLE)
    with pytest.raises(ShapeError, match="'regulate' is for any robot"):
        make_task("circle", CART_POLE)
    with pytest.raises(UnknownNameError, match="effect"):
        effect("joint_damping:elbow", CART_POLE)
    assert effect("rotor_loss", CART_POLE).why_not(CART_POLE) == "rotor_loss is an effect of a quadrotor"
    assert open_model(str(saved(CART_POLE.nominal(), tmp_path))).layouts == CART_POLE.layouts


def saved(equations: Equations, folder: Path) -> Path:
    save_model(equations, folder / "model")
    return folder / "model"


@pytest.mark.parametrize(
    ("part", "instead", "match"),
    [
        ('type="slide" axis="0.6 0 0.8" range="-0.5 0.5"', 'type="ball"', "found a ball"),
        (' ctrlrange="-1 1"', "", "'pull': expected a ctrlrange"),
        ("<worldbody>", "<worldbudy>", "expected an MJCF that MuJoCo opens"),
    ],
)
def test_a_file_that_is_no_robot_is_refused_with_the_reason(
    part: str, instead: str, match: str, tmp_path: Path
) -> None:
    file = tmp_path / "wrong.xml"
    assert part in ARM
    file.write_text(ARM.replace(part, instead))
    with pytest.raises(ModelError, match=match):
        Robot.from_mjcf(file)


def test_a_column_that_a_user_gives_twice_is_refused(arm: Robot) -> None:
    with pytest.raises(ModelError, match="named otherwise than those of joints, found waist"):
        Robot.from_mjcf(arm.description.mjcf, actions={"to_waist": "waist", "lift": "lift"})


def test_a_urdf_which_has_no_actuators_is_refused_with_what_to_do(tmp_path: Path) -> None:
    swings = """
    <robot name="pendulum">
      <link name="post"/>
      <link name="rod"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="hinge" type="revolute"><parent link="post"/><child link="rod"/><axis xyz="0 1 0"/>
        <limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
    </robot>"""
    (tmp_path / "pendulum.urdf").write_text(swings)
    with pytest.raises(ModelError, match=r"expected actuators.*<actuator> section"):
        Robot.from_mjcf(tmp_path / "pendulum.urdf")


def test_the_base_of_a_robot_is_its_first_principles_where_there_are_any(arm: Robot, tmp_path: Path) -> None:
    file = tmp_path / "held.xml"
    held = '<equality><joint joint1="waist" joint2="reach"/></equality></mujoco>'
    file.write_text(ARM.replace("</mujoco>", held))
    given = Robot.from_mjcf(file, rigid_body=arm.nominal)
    cases = {"nominal": (arm, CART_POLE, ROBOTS["differential_drive"], given), "episodes": (Robot.from_mjcf(file),)}
    for base, robots in cases.items():
        assert {robot.recipe.base for robot in robots} == {base}


def test_a_robots_name_as_model_is_its_nominal_equations(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda _: tmp_path)
    assert open_model("cart_pole").to_json() == CART_POLE.nominal().to_json()
    main(["learn", "cart_pole", "--out", str(tmp_path / "base")])
    assert load_model(tmp_path / "base").to_json() == CART_POLE.nominal().to_json()


def test_any_period_is_whole_steps_no_longer_than_the_files(arm: Robot) -> None:
    """Logs of 30 or 60 Hz have a period that no file's step divides."""
    for period in (1 / 30, 1 / 60, 0.0007):
        robot = Robot.from_mjcf(arm.description.mjcf, dt=period)
        plant = MujocoPlant(robot)
        plant.step(robot.rest)
        assert plant.time == pytest.approx(period, rel=1e-9)
        assert plant.mj_model.opt.timestep <= arm.description.physics_dt
    for nothing in (0.0, -0.02, float("nan"), float("inf")):
        with pytest.raises(ModelError, match="more than 0 s"):
            Robot.from_mjcf(arm.description.mjcf, dt=nothing)


def test_an_actuator_that_the_file_lacks_is_refused(arm: Robot) -> None:
    with pytest.raises(UnknownNameError, match="actuator"):
        Robot.from_mjcf(arm.description.mjcf, actions=["push"])


def test_a_log_needs_no_column_of_pushes_that_nobody_applied(tmp_path: Path) -> None:
    robot = ROBOTS["cart_pole"]
    rows = np.linspace(0.0, 1.0, 30)[:, None] * np.ones((1, 6)) * [1.0, 0.1, 0.2, 0.3, 0.4, 0.5]
    names = ("time", *robot.layouts.state.columns, *robot.layouts.action.columns)
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(names), comments="")
    log = read_log(tmp_path / "log.csv", layouts=robot.layouts)
    assert log.layouts.inputs.columns == tuple(f"{joint}_push" for joint in ("slider", "pole"))
    assert not log.inputs.any()
    np.savetxt(tmp_path / "short.csv", rows[:, :-1], delimiter=",", header=",".join(names[:-1]), comments="")
    with pytest.raises(DataError, match=r"columns of the model: drive \(N\)"):
        read_log(tmp_path / "short.csv", layouts=robot.layouts)


ONE_JOINT = """<mujoco><worldbody><body><joint name="swing" axis="0 1 0"/><inertial pos="0 0 -0.5" mass="1"
diaginertia="0.1 0.1 0.1"/></body></worldbody>
<actuator><motor name="torque" joint="swing" ctrlrange="-6 6"/></actuator></mujoco>"""


@pytest.mark.parametrize("key", ["lag:tau", "delay:tau"])
def test_effects_find_actuators_whose_columns_are_called_otherwise(key: str) -> None:
    """The lag of a renamed actuator did nothing in the simulator, nor did the part of a delay below a period."""

    def turned(robot: Robot, key: str) -> Array:
        plant = MujocoPlant(robot, [effect(key, robot).inject(value=0.03)])
        plant.reset()
        return np.array([plant.step(np.array([float(row > 1)])) for row in range(8)])

    own = Robot.from_mjcf(ONE_JOINT, name="own")
    (actuator,) = own.layouts.action.columns
    renamed = Robot.from_mjcf(ONE_JOINT, name="renamed", actions={actuator: "tau"})
    np.testing.assert_array_equal(turned(renamed, key), turned(own, key.replace("tau", actuator)))


def test_an_actuator_may_be_called_as_the_joint_that_it_moves() -> None:
    """As in dm_control's acrobot: such files were refused."""
    same = Robot.from_mjcf(ONE_JOINT.replace('name="torque"', 'name="swing"'), name="same")
    assert (same.layouts.state.columns, same.layouts.action.columns) == (("swing", "swing_rate"), ("swing_cmd",))
    own = Robot.from_mjcf(ONE_JOINT, name="own")
    moved = [MujocoPlant(robot) for robot in (same, own)]
    for plant in moved:
        plant.reset()
    for command in ([2.0], [-3.0]):
        np.testing.assert_array_equal(*(plant.step(np.array(command)) for plant in moved))
    state = torch.tensor([[0.3, 0.0]])
    predicted = [compile_model(robot.nominal())(state, torch.tensor([[2.0]])) for robot in (same, own)]
    torch.testing.assert_close(*predicted)


def test_an_action_cannot_be_called_like_another_actuator() -> None:
    two = ONE_JOINT.replace("</actuator>", '<motor name="spare" joint="swing"/></actuator>')
    (actuator,) = Robot.from_mjcf(ONE_JOINT, name="own").layouts.action.columns
    with pytest.raises(ModelError, match="like no other actuator, found spare"):
        Robot.from_mjcf(two, name="two", actions={actuator: "spare"})


IDLE = """<mujoco><worldbody>
<body><joint name="swing" axis="0 1 0"/><inertial pos="0 0 -0.5" mass="1" diaginertia="0.1 0.1 0.1"/></body>
<body pos="1 0 0"><joint name="idle" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body>
</worldbody><actuator><motor name="torque" joint="swing" ctrlrange="-6 6"/></actuator></mujoco>"""


def test_logs_of_a_robot_that_nothing_holds_calibrate_nothing_and_say_why() -> None:
    """A wheel that spins freely has no motor: that no gain holds it is no reason to give no answer."""
    robot = Robot.from_mjcf(IDLE, name="idle")
    log = Trajectory.from_arrays(np.zeros((60, 4)), np.zeros((60, 1)), robot.layouts, dt=robot.dt, name="still")
    flown, why = flown_along(robot.nominal(), MujocoPlant(robot), Dataset([log]))
    assert flown is None
    assert "expected a robot that commands can hold at its start" in why
