"""A servo that answers within a row: its rates at rows are not those in between, and no sensor is to blame for it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from sym2real.dataset import Dataset
from sym2real.diagnosis.faults.sanity import check
from sym2real.plants import MujocoPlant
from sym2real.robots import Robot
from sym2real.trajectory import Trajectory

# An inertia of 0.012 kg m² that a servo brakes in a hundredth of a second, commanded half as often.
MJCF = """
<mujoco><option timestep="0.001" integrator="implicitfast" gravity="0 0 0"/>
<worldbody><body><joint name="elbow" type="hinge" axis="0 0 1"/>
<inertial pos="0 0 0" mass="1" diaginertia="0.012 0.012 0.012"/><geom size="0.05" mass="0"/></body></worldbody>
<actuator><position name="wanted" joint="elbow" kp="25" kv="1.2" ctrlrange="-1 1"/></actuator></mujoco>
"""
ARM = Robot.from_mjcf(MJCF, name="servo", dt=0.02)


@cache
def swings(seed: int) -> Trajectory:
    """Steps of the command in every row, as of a hand on a stick, and noise of the sensors."""
    rng, plant, rows = np.random.default_rng(seed), MujocoPlant(ARM), []
    smooth = np.convolve(rng.standard_normal(420), np.hanning(7), "same")
    state = plant.reset()
    for command in 0.25 * smooth:
        rows.append((*state, command))
        state = plant.step([command])
    measured = np.array(rows)[10:]
    measured[:, :2] += rng.normal(0.0, [1e-4, 2e-3], (len(measured), 2))
    return Trajectory.from_arrays(measured[:, :2], measured[:, 2:], ARM.layouts, dt=ARM.dt, name=f"swings {seed}")


@pytest.mark.parametrize(("scale", "named"), [(1.0, None), (0.85, 0.85), (1.2, 1.2)])
def test_a_sensor_is_blamed_for_what_the_model_does_not_predict(scale: float, named: float | None) -> None:
    logs = Dataset(log.with_columns({"elbow_rate": scale * log.column("elbow_rate")}) for log in map(swings, range(4)))
    faults = check(ARM.nominal(), logs).faults
    assert [fault.effect for fault in faults] == ([] if named is None else ["sensor_scale:elbow_rate"])
    if named is not None:
        assert faults[0].value == pytest.approx(named, rel=0.02)
    assert check(None, logs).faults  # held against angles alone the rates are not what those change by
