"""A user's own robot: an arm of two links, and a plain MuJoCo script that swings it and writes what it measured."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

from sym2real.trajectory import Array

STEP = 0.01  # s
MJCF = """
<mujoco model="two links">
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="RK4"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="q1" axis="0 1 0" range="-2.5 2.5" limited="true" damping="0.05"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
      <body name="lower" pos="0 0 -0.4">
        <joint name="q2" axis="0 1 0" range="-2.5 2.5" limited="true" damping="0.02"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.025" mass="0.8" contype="0" conaffinity="0"/>
        <site name="hand" pos="0 0 -0.35"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="tau1" joint="q1" ctrlrange="-15 15" ctrllimited="true"/>
    <motor name="tau2" joint="q2" ctrlrange="-8 8" ctrllimited="true"/>
  </actuator>
</mujoco>
"""
COLUMNS = ("time", "q1", "q2", "q1_rate", "q2_rate", "tau1", "tau2")
BALL = '<body pos="0 0 -0.35"><inertial pos="0 0 0" mass="{}" diaginertia="1e-7 1e-7 1e-7"/></body>'


def swings(damping: float = 0.0, load: float = 0.0, *, seconds: float = 12.0, seed: int = 0, mjcf: str = MJCF) -> Array:
    """What a log holds, :data:`COLUMNS` in SI units with sensor noise ``# (rows, 7)``.

    Args:
        damping: of the shoulder beyond that of the file, N m s.
        load: in the hand, kg.
        seconds: of the log.
        seed: of the motion and the noise.
        mjcf: of what swings.
    """
    text = mjcf.replace('damping="0.05"', f'damping="{0.05 + damping}"')
    text = text.replace('<site name="hand"', f'{BALL.format(load)}<site name="hand"') if load else text
    model, rng = mujoco.MjModel.from_xml_string(text), np.random.default_rng(seed)
    data, rows = mujoco.MjData(model), []
    size, pace, phase = (
        np.array([[2.5, 1.5, 1.0], [0.9, 0.6, 0.5]]),
        rng.uniform(1, 4, (2, 3)),
        rng.uniform(0, 6, (2, 3)),
    )
    goal = rng.uniform(-0.8, 0.8, 2)
    for time in STEP * np.arange(round(seconds / STEP)):
        swing = (size * np.sin(pace * time + phase)).sum(axis=1) + rng.normal(0.0, [0.3, 0.1])
        torque = swing + np.array([8.0, 3.0]) * (goal - data.qpos) - np.array([0.8, 0.2]) * data.qvel
        data.ctrl[:] = np.clip(torque, [-15.0, -8.0], [15.0, 8.0])
        place, rate = data.qpos + rng.normal(0.0, 5e-4, 2), data.qvel + rng.normal(0.0, 5e-3, 2)
        rows.append([time, *place, *rate, *data.ctrl])
        mujoco.mj_step(model, data, nstep=round(STEP / model.opt.timestep))
    return np.array(rows)


def write(file: Path, values: Array, columns: Sequence[str] = COLUMNS) -> Path:
    """A CSV file of these columns."""
    np.savetxt(file, values, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return file
