"""A servo whose force ends: MuJoCo's own limit of what actuators give a joint, which no command and no log shows."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import two_links

from sym2real.dataset import Dataset
from sym2real.diagnosis import diagnose
from sym2real.robots import Robot
from sym2real.trajectory import Trajectory

SERVOS = """<actuator>
  <position name="to_q1" joint="q1" kp="60" kv="4" ctrlrange="-2.5 2.5"/>
  <position name="to_q2" joint="q2" kp="30" kv="2" ctrlrange="-2.5 2.5"/>
</actuator></mujoco>"""
MJCF = two_links.MJCF.partition("<actuator>")[0] + SERVOS
MOST, STEP = 20.0, 0.02  # N m, s
ROBOT = Robot.from_mjcf(MJCF, name="servos", dt=STEP)


def steps_to_goals(seed: int) -> Trajectory:
    """Goals that change twice a second, of which the larger steps ask for more than the servo gives."""
    ends = f'name="q1" actuatorfrclimited="true" actuatorfrcrange="{-MOST} {MOST}"'
    model, rng = mujoco.MjModel.from_xml_string(MJCF.replace('name="q1"', ends, 1)), np.random.default_rng(seed)
    data, goal, rows = mujoco.MjData(model), np.zeros(2), []
    for row in range(300):
        goal = rng.uniform(-1.0, 1.0, 2) if row % 25 == 0 else goal
        data.ctrl[:] = goal + rng.normal(0.0, 0.03, 2)
        rows.append([*(data.qpos + rng.normal(0.0, 5e-4, 2)), *(data.qvel + rng.normal(0.0, 5e-3, 2)), *data.ctrl])
        mujoco.mj_step(model, data, nstep=round(STEP / model.opt.timestep))
    values = np.array(rows)
    return Trajectory.from_arrays(values[:, :4], values[:, 4:], ROBOT.layouts, dt=STEP, name=f"run {seed}")


@pytest.mark.slow
def test_a_servo_that_gives_no_more_is_no_rate_limit_of_its_command() -> None:
    found = diagnose(ROBOT.nominal(), Dataset(map(steps_to_goals, range(6))))
    assert [finding.effect for finding in found.findings] == ["servo_limit:q1"], found.summary
    assert found.findings[0].values["value"] == pytest.approx(MOST, rel=0.01)
