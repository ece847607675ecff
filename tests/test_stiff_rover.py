"""A rover with stiff wheel servos whose velocities are differences of noisy places, rolled by a script of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.robots import Robot
from sym2real.robots.planar import STATE
from sym2real.trajectory import Array, Trajectory

DT, RADIUS, TRACK, SERVO, CHASSIS, WHEEL, TURNING = 0.02, 0.06, 0.34, 0.8, 6.0, 0.3, 0.09
WHEEL_MJCF = """
<body name="{0}_body" pos="0 {1} 0"><joint name="{0}_wheel" axis="0 1 0"/>
  <geom type="ellipsoid" size="0.06 0.06 0.02" euler="90 0 0" mass="0.3"/></body>
"""
MJCF = f"""
<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody>
<geom type="plane" size="20 20 .1"/>
<body name="rover" pos="0 0 0.06"><freejoint/><inertial pos="0 0 0" mass="6" diaginertia="0.09 0.09 0.09"/>
<geom type="sphere" size="0.02" pos="-0.15 0 -0.04" condim="1" priority="1" mass="0"/>
<geom type="sphere" size="0.02" pos="0.15 0 -0.04" condim="1" priority="1" mass="0"/>
{WHEEL_MJCF.format("left", 0.17)}{WHEEL_MJCF.format("right", -0.17)}</body></worldbody>
<actuator><velocity name="left" joint="left_wheel" kv="0.8" ctrlrange="-25 25"/>
<velocity name="right" joint="right_wheel" kv="0.8" ctrlrange="-25 25"/></actuator>
<keyframe><key qpos="0 0 0.06 1 0 0 0 0 0"/></keyframe></mujoco>
"""


def rolled(rng: np.random.Generator, left: float) -> Array:
    """x, y, yaw, speed and turning rate in SI units, and both commands in rad/s ``# (rows, 7)``.

    Two masses on wheels that roll: the sums of the servos' pushes, and what they turn.

    Args:
        rng: of the manoeuvre.
        left: radius of the left wheel in m.
    """
    radii, arms = np.array([left, RADIUS]), np.array([-0.5, 0.5]) * TRACK
    spun = 0.4 * WHEEL * RADIUS**2 / radii**2
    inertia = TURNING + 2 * WHEEL * (TRACK / 2) ** 2 + 2 * WHEEL / 5 * (RADIUS**2 + 0.02**2) + (spun * arms**2).sum()
    masses = np.array([CHASSIS + 2 * WHEEL + spun.sum(), inertia])
    pace, phase, state, rows = rng.uniform(0.3, 2.5, (2, 3)), rng.uniform(0.0, 6.0, (2, 3)), np.zeros(5), []

    def slope(_: float, now: Array, sent: Array) -> Array:
        push = SERVO * (sent - (now[3] + now[4] * arms) / radii) / radii
        return np.array(
            [now[3] * np.cos(now[2]), now[3] * np.sin(now[2]), now[4], *([push.sum(), push @ arms] / masses)]
        )

    for row in range(600):
        speed, turning = np.array([0.2, 0.5]) * np.sin(pace * row * DT + phase).sum(1) + (0.5, 0.0)
        sent = (speed + turning * arms) / RADIUS + 0.4 * rng.standard_normal(2)
        rows.append([*state, *sent])
        state = solve_ivp(slope, (0.0, DT), state, args=(sent,), rtol=1e-8, atol=1e-10).y[:, -1]
    return np.array(rows)


def logged(rows: Array, rng: np.random.Generator, robot: Robot, name: str) -> Trajectory:
    place = rows[:, :2] + 0.003 * rng.standard_normal((len(rows), 2))
    yaw = rows[:, 2] + np.deg2rad(0.3) * rng.standard_normal(len(rows))
    rate = rows[:, 4] + 0.01 * rng.standard_normal(len(rows))
    state = np.column_stack([place, np.sin(yaw), np.cos(yaw), np.gradient(place, DT, axis=0), rate])
    inputs = np.zeros((len(rows), len(robot.layouts.inputs)))
    return Trajectory(DT * np.arange(len(rows)), state, rows[:, 5:], inputs, robot.layouts, name=name)


@pytest.mark.slow
def test_the_wheel_that_is_too_small_is_named_and_not_one_that_is_damped(tmp_path: Path) -> None:
    """What the start of a velocity is off by turns a robot whose wheels differ, and not one with a damped wheel."""
    (tmp_path / "rover.xml").write_text(MJCF)
    robot = Robot.from_mjcf(tmp_path / "rover.xml", state=STATE, dt=DT)
    rng = np.random.default_rng(0)
    logs = Dataset(logged(rolled(rng, 0.95 * RADIUS), rng, robot, str(number)) for number in range(6))
    (finding,) = diagnose(robot.nominal(), logs, exclude=["sensor_*"]).findings
    assert finding.effect == "wheel_radius:left_wheel"
    assert finding.values["value"] == pytest.approx(0.95, abs=0.003)
    assert "joint_damping:left_wheel" in finding.group
