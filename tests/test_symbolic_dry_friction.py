"""Coulomb's law over a time step against its integration in ten thousand steps."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
from sympy import Symbol, lambdify

from sym2real.effects import effect
from sym2real.effects.composing import compose
from sym2real.robots import Robot
from sym2real.symbolic import compile_model
from sym2real.symbolic.dry_friction import dry_friction
from sym2real.trajectory import Array

STEP, FINE, INERTIA, FRICTION = 0.01, 10_000, 0.06, 0.5
RATE, MOST, OTHER = (Symbol(name, real=True) for name in ("rate", "most", "other"))
mean_friction = lambdify([MOST, RATE, OTHER], dry_friction(MOST, RATE, STEP, INERTIA, OTHER), "numpy")


def slid(rates: Array, others: Array) -> tuple[Array, Array]:
    """Rates after a step of many, and the way until then ``# (n,)``; friction takes what is left, or holds."""
    part, way, rates = STEP / FINE, np.zeros_like(rates), rates.copy()
    for _ in range(FINE):
        free = rates + part / INERTIA * others
        after = np.sign(free) * np.maximum(np.abs(free) - part / INERTIA * FRICTION, 0.0)
        way += part / 2 * (rates + after)
        rates = after
    return rates, way


def test_it_brakes_holds_and_turns_round_as_coulomb_s_law_does() -> None:
    rng = np.random.default_rng(0)
    rates = np.concatenate([np.zeros(20), rng.uniform(-0.15, 0.15, 400)])
    others = rng.uniform(-1.5, 1.5, len(rates))
    after, way = slid(rates, others)
    mean, early = mean_friction(FRICTION, rates, others)
    found = rates + STEP / INERTIA * (mean + others)
    assert (after == 0.0).sum() > 50
    assert ((after * rates < 0.0) & (after != 0.0)).sum() > 50
    np.testing.assert_allclose(found, after, atol=2e-3 * STEP / INERTIA * FRICTION)
    np.testing.assert_allclose(STEP * (rates + found) / 2 + early / INERTIA, way, atol=2e-3 * STEP**2 / INERTIA)


@pytest.mark.parametrize(("rate", "other"), [(0.3, 0.0), (-0.3, 0.2), (0.01, -0.4)])
def test_no_friction_at_all_has_a_derivative_that_brakes(rate: float, other: float) -> None:
    """Against the rate as it is, and against what moves it on where it turns round within the step."""
    slope = mean_friction(1e-6, rate, other)[0] / 1e-6
    until = min(1.0, abs(INERTIA / STEP * rate / other)) if rate * other < 0 else 1.0
    assert slope * np.sign(rate) == pytest.approx(1.0 - 2.0 * until, abs=0.05)
    assert float(mean_friction(0.0, rate, other)[0]) == 0.0


LEG = """
<mujoco><compiler angle="radian"/><option timestep="0.001" integrator="RK4"/><worldbody>
<body><joint name="hip" axis="0 1 0" damping="0.1"/><inertial pos="0 0 -0.18" mass="4" diaginertia="0.05 0.05 0.006"/>
<body pos="0 0 -0.4"><joint name="knee" axis="0 1 0" damping="0.1"/>
<inertial pos="0 0 -0.15" mass="1.8" diaginertia="0.02 0.02 0.003"/></body></body></worldbody>
<actuator><motor name="hip_motor" joint="hip" ctrlrange="-60 60"/>
<motor name="knee_motor" joint="knee" ctrlrange="-60 60"/></actuator></mujoco>
"""


@pytest.mark.parametrize(("dt", "near"), [(0.01, 0.005), (0.04, 0.01)])
def test_a_joint_that_chatters_about_rest_beside_another_goes_as_in_short_steps(
    tmp_path: Path, dt: float, near: float
) -> None:
    """Its rate after ten periods; friction that was held against the joint's own forces alone was 0.1 rad/s off."""
    (tmp_path / "leg.xml").write_text(LEG)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "leg.xml"))
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    starts = np.column_stack([rng.uniform(-0.6, 0.6, (40, 2)), rng.normal(0.0, [0.5, 0.03], (40, 2))])
    torques = rng.normal(0.0, [6.0, 0.6], (40, 10, 2)) + 4.0 * starts[:, None, :2]
    ends = []
    for start, sent in zip(starts, torques, strict=True):
        data.qpos[:], data.qvel[:] = start[:2], start[2:]
        for command in sent:
            data.ctrl[:] = command
            for _ in range(round(dt / 1e-4)):
                data.qfrc_applied[1] = -FRICTION * np.tanh(data.qvel[1] / 0.002)
                mujoco.mj_step(model, data)
        ends.append(np.concatenate([data.qpos, data.qvel]))
    robot = Robot.from_mjcf(tmp_path / "leg.xml", dt=dt)
    module = compile_model(compose(robot.nominal(), [(effect("joint_friction:knee", robot), {"value": FRICTION})]))
    state = torch.as_tensor(starts)
    for command in torch.as_tensor(torques).unbind(1):
        state = module(state, command)
    off = np.sqrt(np.mean((state.numpy() - np.array(ends)) ** 2, axis=0))
    assert off[3] < near
    assert off[1] < 10 * dt * near
