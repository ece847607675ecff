"""A robot of joints in its owner's own MuJoCo script, with the plain simulator that the package makes and without."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.plants import MujocoPlant
from sym2real.robots import Robot
from sym2real.trajectory import Trajectory

ARM = """
<mujoco model="two_link">
  <option timestep="0.002" integrator="{integrator}"/>
  <worldbody>
    <body pos="0 0 1">
      <joint name="shoulder" type="hinge" axis="0 1 0" damping="{damping}"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="1.2"/>
      <body pos="0 0 -0.4">
        <joint name="elbow" type="hinge" axis="0 1 0" damping="0.05" stiffness="{stiffness}"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.025" mass="0.8"/>
        <geom type="sphere" size="0.001" pos="0 0 -0.35" mass="{load}"/>
        <site name="hand" pos="0 0 -0.35"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="lift" joint="shoulder" ctrlrange="-8 8"/>
    <motor name="bend" joint="elbow" ctrlrange="-4 4"/>
  </actuator>
</mujoco>
"""
HEALTHY = {"damping": 0.05, "stiffness": 0.0, "load": 1e-6, "integrator": "RK4"}
STEPS, SUBSTEPS, DT = 400, 10, 0.02


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The arm as its owner describes it."""
    file = tmp_path_factory.mktemp("arm") / "arm.xml"
    file.write_text(ARM.format(**HEALTHY))
    return Robot.from_mjcf(file)


def logged(robot: Robot, seed: int, **changed: float | str) -> Trajectory:
    """A run of a script of its owner: plain MuJoCo, sines on damped motors, noise of encoders."""
    rng = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(ARM.format(**(HEALTHY | changed)))
    data, frequency, phase = mujoco.MjData(model), rng.uniform(0.5, 3, (2, 3)), rng.uniform(0, 2 * np.pi, (2, 3))
    states, actions = np.empty((STEPS, 4)), np.empty((STEPS, 2))
    for step in range(STEPS):
        sines = np.sin(frequency * step * DT + phase).sum(1)
        wanted = np.array([2.7, 1.0]) * sines - np.array([0.6, 0.3]) * data.qvel
        data.ctrl[:] = actions[step] = np.clip(wanted, robot.limits.low, robot.limits.high)
        states[step] = [*(data.qpos + rng.normal(0, 0.001, 2)), *(data.qvel + rng.normal(0, 0.005, 2))]
        for _ in range(SUBSTEPS):
            mujoco.mj_step(model, data)
    return Trajectory.from_arrays(states, actions, robot.layouts, dt=DT, name=f"run {seed}")


def runs(robot: Robot, **changed: float | str) -> Dataset:
    return Dataset([logged(robot, seed, **changed) for seed in range(6)])


@pytest.mark.slow
@pytest.mark.parametrize("simulator", [False, True], ids=["equations", "simulator"])
def test_of_a_healthy_arm_nothing_is_missing(robot: Robot, simulator: bool) -> None:
    found = diagnose(robot.nominal(), runs(robot), MujocoPlant(robot) if simulator else None)
    assert found.verdict == "NOTHING_MISSING", found.summary
    assert found.leftover is None


@pytest.mark.slow
@pytest.mark.parametrize("simulator", [False, True], ids=["equations", "simulator"])
def test_a_load_and_damping_are_found_alike_with_a_simulator_and_without(robot: Robot, simulator: bool) -> None:
    """Constants fitted to a simulator without the load extrapolate badly: they must make the logs likelier to stay."""
    logs = runs(robot, damping=0.4, load=0.2)
    found = diagnose(robot.nominal(), logs, MujocoPlant(robot) if simulator else None)
    values = {finding.effect: finding.parameters["value"] for finding in found.findings}
    assert set(values) == {"load:hand", "joint_damping:shoulder"}, found.summary
    assert values["load:hand"].value == pytest.approx(0.2, rel=0.02)
    assert values["joint_damping:shoulder"].value == pytest.approx(0.35, rel=0.05)
    assert found.leftover is None
    assert found.misfit[1] < 1.2


@pytest.mark.slow
def test_a_joint_may_brake_less_than_its_description_says_down_to_nothing(robot: Robot) -> None:
    """Else gains and masses that are all too large by one factor would say so."""
    found = diagnose(robot.nominal(), runs(robot, damping=0.0))
    assert [finding.effect for finding in found.findings] == ["joint_damping:shoulder"], found.summary
    assert found.findings[0].parameters["value"].value == pytest.approx(-0.05, abs=0.002)
    assert found.verdict == "EFFECT"


@pytest.mark.slow
def test_a_cable_that_pulls_at_a_joint_is_no_damping(robot: Robot) -> None:
    found = diagnose(robot.nominal(), runs(robot, stiffness=0.6))
    assert [finding.effect for finding in found.findings] == ["joint_stiffness:elbow"], found.summary
    assert found.findings[0].parameters["value"].value == pytest.approx(0.6, rel=0.05)
    assert found.leftover is None
