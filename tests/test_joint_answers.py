"""What a person reads of a robot of joints: printed answers, tables in narrow terminals, figures, its own effects."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
import two_links
from cli_results import result_of
from rich.console import Console

from sym2real.cli import main
from sym2real.dataset import Dataset
from sym2real.diagnosis import Diagnosis, Plan, diagnose, locate, try_effect
from sym2real.diagnosis.design.visible import Visible
from sym2real.effects import applicable, effect
from sym2real.effects.bound import NO_COLUMN
from sym2real.effects.searching import SETTLED
from sym2real.logs import read_logs
from sym2real.report.diagnosis import untested_lines
from sym2real.report.plan import plan_report
from sym2real.robots import Robot
from sym2real.symbolic import compile_model, rollout, save_model
from sym2real.trajectory import Trajectory

LINKS = Robot.from_mjcf(two_links.MJCF, name="links", dt=two_links.STEP)
BASE = LINKS.nominal()


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("swings")
    swings = [two_links.swings(load=0.3, seed=seed, seconds=8.0) for seed in (1, 2)]
    files = [two_links.write(folder / f"{number}.csv", rows) for number, rows in enumerate(swings)]
    return read_logs(files, layouts=LINKS.layouts)


@pytest.fixture(scope="module")
def found(logs: Dataset) -> Diagnosis:
    return diagnose(BASE, logs, exclude=["*:tau?", "sensor_*"])


def test_a_printed_diagnosis_has_values_with_intervals_and_what_it_cannot_tell(found: Diagnosis) -> None:
    text, (finding,) = str(found), found.findings
    assert found.summary.split(";")[0] in text
    estimate = finding.parameters["value"]
    assert f"value = {estimate.text}  95 % {estimate.low:.3g} … {estimate.high:.3g}" in text
    assert finding.fix in " ".join(text.split())
    assert "not tested: " in text
    told = {entry.reason for entry in found.not_tried} - {SETTLED}
    told = {reason for reason in told if not reason.endswith(NO_COLUMN)}
    assert told and all(reason in " ".join(text.split()) for reason in told)
    assert SETTLED not in " ".join(text.split())
    assert "\x1b" not in text
    assert "\n" not in repr(found)
    (line,) = untested_lines(found, Path("page.html"))  # where reasons stand on a page, names will do
    assert line.startswith("not tested (page.html says why): ") and not any(reason in line for reason in told)


def test_a_hypothesis_that_another_effect_explains_away_is_not_supported(logs: Dataset) -> None:
    """A load in the hand looks a little like friction; beside the load, nothing is left for friction to do."""
    for key in ("joint_friction:q2", "gain:tau2"):
        tried = try_effect(BASE, key, logs, exclude=["sensor_*"])
        assert tried.gain > 0.05
        assert tried.outdone == (key,)
        assert not tried.supported
        assert f"{tried.rivals[0].effect} in its place lowers it" in tried.summary
        assert tried.rivals[0].effect.startswith("load:")
        assert not tried.rivals[0].as_good
    assert try_effect(BASE, "load:hand", logs, exclude=["sensor_*"]).supported


def test_a_hypothesis_beside_a_larger_effect_is_supported(tmp_path: Path) -> None:
    """The shoulder's damping, of which a load in the hand does more in its place, and not all."""
    swings = [two_links.swings(damping=0.3, load=0.1, seed=seed, seconds=8.0) for seed in (1, 2)]
    files = [two_links.write(tmp_path / f"{number}.csv", rows) for number, rows in enumerate(swings)]
    tried = try_effect(BASE, "joint_damping:q1", read_logs(files, layouts=LINKS.layouts), exclude=["sensor_*"])
    assert tried.rivals[0].better
    assert tried.outdone == ()
    assert tried.supported, tried.summary
    assert "load:hand in its place lowers it" in tried.summary


@pytest.mark.slow
def test_the_zero_of_an_encoder_is_named(tmp_path: Path) -> None:
    """Of the elbow's alone; the shoulder's is a base that stands askew, which these logs cannot tell from it."""
    for place, key in ((1, "gravity_tilt"), (2, "sensor_bias:q2")):
        swings = [two_links.swings(seed=seed) for seed in (1, 2, 3)]
        for rows in swings:
            rows[:, place] += 0.1
        files = [two_links.write(tmp_path / f"{place}_{number}.csv", rows) for number, rows in enumerate(swings)]
        (finding,) = diagnose(BASE, read_logs(files, layouts=LINKS.layouts)).findings
        assert finding.effect == key
        assert f"sensor_bias:q{place}" in {finding.effect, *finding.group}


def test_dry_friction_holds_a_light_link() -> None:
    """It could stop what turns at 0.2 rad/s within a period, and may not push it back and forth instead."""
    held = effect("joint_friction:q2", BASE).substitute(BASE, {"value": 0.3})
    start = torch.tensor([0.0, 0.05, 0.0, 0.01], dtype=torch.float64)
    states = rollout(compile_model(held, dtype=torch.float64), start, torch.zeros(60, 2, dtype=torch.float64))
    assert float(states[:, 3].abs().max()) < 0.03


def test_an_effect_of_another_robot_leads_to_the_one_that_joints_have(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_model(BASE, tmp_path / "links")
    wanted = {
        "payload": "load:hand", "added_mass": "load:hand", "rate_damping": "joint_damping:q1, joint_damping:q2",
        "slope": "gravity_tilt",
    }  # fmt: skip
    for key, instead in wanted.items():
        with pytest.raises(SystemExit):
            main(["add", str(tmp_path / "links"), key, "value=0.1", "--out", str(tmp_path / "new")])
        assert f"in its place this robot has {instead}\n" in capsys.readouterr().err
    assert set(", ".join(wanted.values()).split(", ")) <= {one.key for one in applicable(BASE)}


@pytest.mark.parametrize(
    ("key", "quantity"),
    [("load:hand", "load_hand"), ("armature:q1", "armature_q1"), ("joint_damping:q2", "damping_q2")],
)
def test_a_model_shows_what_was_put_into_it(key: str, quantity: str, tmp_path: Path) -> None:
    """The quantity has the value itself; twice half an effect is the effect."""
    once = effect(key, BASE).substitute(BASE, {"value": 0.3})
    half = effect(key, BASE).substitute(BASE, {"value": 0.15})
    before = float(BASE.quantities[quantity])
    assert float(once.quantities[quantity]) == pytest.approx(before + 0.3)
    state, action = np.array([0.4, -0.6, 1.0, -2.0]), np.array([1.0, 0.5])
    twice = effect(key, half).substitute(half, {"value": 0.15})
    np.testing.assert_allclose(once.predict(state, action), twice.predict(state, action), atol=1e-12)
    assert np.abs(once.predict(state, action) - BASE.predict(state, action)).max() > 1e-5
    save_model(once, tmp_path / "model")
    shown = result_of(["show", str(tmp_path / "model")], tmp_path)
    assert any(line.replace(" ", "") == f"{quantity}={before + 0.3:g}" for line in shown["equations"])


def row(key: str, parameter: str, size: float | None, like: tuple[str, ...] = ()) -> Visible:
    larger = None if size is None else 3 * size
    return Visible(key, parameter, "kg m²", size, larger, larger, "gain:drive", like, (), "fast motion")


@pytest.mark.parametrize("width", [52, 60, 80, 120])
def test_a_plan_breaks_no_word_and_cuts_no_number(width: int) -> None:
    names = ("joint_friction:left_wheel", "armature:right_wheel", "gain:drive")
    rows = (
        row(names[0], "value", 1.2e-5, names[1:]), row(names[1], "value", 3.4e7), row("gravity_tilt", "pitch", None),
        row(names[2], "value", 0.00012, (names[0],)),
    )  # fmt: skip
    console = Console(file=io.StringIO(), width=width, emoji=False)
    console.print(plan_report(Plan(rows, 16.0, 12)))
    text = console.file.getvalue()
    assert "…" not in text
    assert all(len(line.rstrip()) <= width for line in text.splitlines())
    for word in (*names, "1.2e-05", "3.4e+07", "unseen", "gravity_tilt pitch", "0.00012", "kg m²"):
        assert word in text
    assert f"  {names[0]}: " in text
    told = text[text.index("what is found before") :]
    assert f"  {names[1]}: gain:drive, from 1e+08 kg m² on" in " ".join(told.split("\n")).replace("   ", "  ")


def test_where_a_model_fails_is_told_by_its_joints(logs: Dataset, tmp_path: Path) -> None:
    """The elbow of this arm meets a stop that the model does not have: it fails where the elbow is near it."""
    stopped = two_links.MJCF.replace(
        'name="q2" axis="0 1 0" range="-2.5 2.5"', 'name="q2" axis="0 1 0" range="-2.5 0.1"'
    )
    swings = [two_links.swings(seed=seed, seconds=8.0, mjcf=stopped) for seed in (1, 2, 4)]
    files = [two_links.write(tmp_path / f"{number}.csv", rows) for number, rows in enumerate(swings)]
    where = locate(BASE, read_logs(files, layouts=LINKS.layouts))[0]
    assert where.feature == "q2"
    assert where.statement.startswith("where q2 is above ")
    assert 0.0 < where.low < where.high < 0.12


GEARED = """
<mujoco model="geared">
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <body name="wrist">
      <joint name="q" axis="0 0 1" damping="0.02"/>
      <geom type="capsule" fromto="0 0 0 0.05 0 0" size="0.01" mass="0.05" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="q" kp="3" kv="0.1" ctrlrange="-2 2"/></actuator>
</mujoco>
"""


def test_a_servo_is_told_no_place_beyond_its_joints_range() -> None:
    """MuJoCo converts a joint's range from degrees, and not what its servo is told."""
    text = GEARED.replace('axis="0 0 1"', 'axis="0 0 1" range="-90 60"').replace('"-2 2"', '"-90 60"')
    robot = Robot.from_mjcf(text.replace("<option", '<compiler angle="degree" autolimits="true"/><option'), name="d")
    np.testing.assert_allclose(np.rad2deg([robot.low[0], robot.high[0]]), [-90.0, 60.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value", "armature"), [("joint_friction:q", 0.05, 2e-3), ("joint_damping:q", 0.1, 0.0)]
)
def test_what_brakes_a_light_joint_may_be_large_beside_its_inertia(key: str, value: float, armature: float) -> None:
    """A servo drives 2 g m², or 0.04 without a gear: rates decay within a millisecond, of a period of ten."""
    text = GEARED.replace("damping=", f'armature="{armature}" damping=')
    spec, robot = mujoco.MjSpec.from_string(text), Robot.from_mjcf(text, name="geared", dt=0.01)
    joint = spec.joint("q")
    joint.frictionloss, joint.damping[0] = (value, 0.02) if "friction" in key else (0.0, 0.02 + value)
    model, rng = spec.compile(), np.random.default_rng(0)
    data, rows = mujoco.MjData(model), []
    for step in range(3000):
        told = 1.2 * np.sin(0.02 * step) * np.sin(0.0031 * step)
        rows.append([0.01 * step, data.qpos[0] + rng.normal(0.0, 5e-4), data.qvel[0] + rng.normal(0.0, 0.02), told])
        data.ctrl[:] = told
        mujoco.mj_step(model, data, 10)
    tried = try_effect(robot.nominal(), key, logged(rows, robot), exclude=["*"])
    assert tried.supported, tried.summary
    assert tried.finding.values["value"] == pytest.approx(value, rel=0.1)


def logged(rows: Sequence[Sequence[float]], robot: Robot) -> Trajectory:
    """Time, angle, rate and command of a robot of one joint."""
    time, *columns = np.array(rows).T
    return Trajectory(time, np.stack(columns[:2], 1), columns[2][:, None], np.zeros((len(time), 1)), robot.layouts)


def test_a_gears_damping_may_be_large_beside_a_light_link() -> None:
    """A description without what a link is driven through, whose rate decays in 1/25 s: four periods."""
    text = GEARED.replace(' damping="0.02"', "").replace("<position ", "<motor ").replace(' kp="3" kv="0.1"', "")
    robot, spec = Robot.from_mjcf(text, name="geared", dt=0.01), mujoco.MjSpec.from_string(text)
    inertia, rng = robot.numbers["q_inertia"], np.random.default_rng(0)
    spec.joint("q").damping[0] = value = 25.0 * inertia
    model = spec.compile()
    data, rows = mujoco.MjData(model), []
    for step in range(3000):
        place, rate = data.qpos[0] + rng.normal(0.0, 5e-4), data.qvel[0] + rng.normal(0.0, 0.02)
        wanted = 0.6 * np.sin(0.02 * step) * np.sin(0.0031 * step) + rng.normal(0.0, 0.05)
        told = 300.0 * inertia * (wanted - place - 0.3 * rate)
        rows.append([0.01 * step, place, rate, told])
        data.ctrl[:] = told
        mujoco.mj_step(model, data, 10)
    tried = try_effect(robot.nominal(), "joint_damping:q", logged(rows, robot), exclude=["*"])
    assert tried.supported, tried.summary
    assert tried.finding.values["value"] == pytest.approx(value, rel=0.1)


HELD = """<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <body name="head">
      <joint name="tilt" type="hinge" axis="0 1 0" damping="0.03"/>
      <inertial pos="0.03 0 0.01" mass="0.6" diaginertia="0.001 0.0016 0.0014"/>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="tilt" kp="5" kv="0.16" ctrlrange="-1 1" forcerange="-3 3"/></actuator>
</mujoco>"""


@pytest.mark.parametrize("friction", [0.03, 0.12, 0.3])
def test_dry_friction_holds_a_joint_against_its_servo(tmp_path: Path, friction: float) -> None:
    """Slow commands move such a joint by fits and starts: up to c/kp behind; MuJoCo's own constraint, made hard."""
    (tmp_path / "head.xml").write_text(HELD)
    robot = Robot.from_mjcf(tmp_path / "head.xml", dt=0.01)
    base, time = robot.nominal(), robot.dt * np.arange(800)
    commands = 0.3 * np.sin(1.3 * time) + 0.2 * np.sign(np.sin(7.0 * time))

    def measured(friction: float) -> list[float]:
        model = mujoco.MjModel.from_xml_string(HELD)
        model.dof_frictionloss[:] = friction
        model.dof_solimp[:], model.dof_solref[:] = (0.999, 0.9999, 1e-3, 0.5, 2), 0.002
        data, angles = mujoco.MjData(model), []
        for command in commands:
            data.ctrl[:] = command
            mujoco.mj_step(model, data, round(robot.dt / model.opt.timestep))
            angles.append(float(data.qpos[0]))
        return angles

    def missed(friction: float, angles: list[float]) -> float:
        equations = effect("joint_friction:tilt", robot).substitute(base, {"value": friction})
        start, actions = torch.zeros(1, 2, dtype=torch.float64), torch.as_tensor(commands)[None, :, None]
        predicted = rollout(compile_model(equations, dtype=torch.float64), start, actions)[0, :, 0].numpy()
        return float(np.sqrt(np.mean(np.square(predicted - angles))))

    held = measured(friction)
    assert (np.abs(np.diff(held)) < 1e-6).mean() > 0.02  # it does stand
    assert missed(friction, held) < 1.2 * missed(0.0, measured(0.0))  # no more than without any
    assert missed(0.0, held) > 3.0 * missed(friction, held)
