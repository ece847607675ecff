"""MPPI with first-principles equations on the MuJoCo plants, and with MuJoCo itself as the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from sym2real.control import MPPI
from sym2real.experiments.study.judged import MujocoModel
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.symbolic import compile_model
from sym2real.tasks import Task, make_task
from sym2real.trajectory import Trajectory


def control(robot: Robot, task: Task, steps: int, samples: int) -> Trajectory:
    mppi = MPPI(compile_model(robot.nominal()), robot, task, settings=replace(robot.mppi, samples=samples))
    trajectory = run_episode(MujocoPlant(robot), mppi, task, seed=1, steps=steps)
    assert len(trajectory) == steps
    assert mppi.plan is not None and mppi.plan.rejected == 0
    return trajectory


def position_error(trajectory: Trajectory) -> np.ndarray:
    position = trajectory.layouts.state.field("position").columns
    return np.linalg.norm([trajectory.column(axis) - trajectory.column(f"ref_{axis}") for axis in position], axis=0)


def test_quadrotor_flies_to_a_goal_and_stays_there() -> None:
    error = position_error(control(CRAZYFLIE, make_task("hover", CRAZYFLIE, goal=(0.6, -0.5, 1.5)), 100, 128))
    assert error[0] > 0.9
    assert error[-15:].max() < 0.06


def test_quadrotor_follows_a_circle() -> None:
    error = position_error(control(CRAZYFLIE, make_task("circle", CRAZYFLIE), 100, 128))
    assert error[50:].mean() < 0.04


@pytest.mark.parametrize("region", ["seen", "unseen"])
def test_car_parks_forward_and_in_reverse(region: str) -> None:
    trajectory = control(MUSHR, make_task("park", MUSHR, start_region=region), 120, 128)
    assert position_error(trajectory)[-20:].mean() < 0.1


def test_predicts_what_then_happens() -> None:
    """The rollout of the mean is where the plant goes when the mean is sent."""
    task = make_task("circle", CRAZYFLIE)
    plant, mppi = MujocoPlant(CRAZYFLIE), MPPI(compile_model(CRAZYFLIE.nominal()), CRAZYFLIE, task, seed=3)
    state = plant.reset(task.start(np.random.default_rng(0)))
    for step in range(3):
        state = plant.step(mppi.act(state, step))
    mppi.act(state, 3)
    predicted = mppi.improve(state, 3, torch.zeros_like(mppi.mean)[None]).states[0].numpy()
    happened = np.array([plant.step(action) for action in mppi.mean.double().numpy()])
    assert np.abs(happened - predicted)[:, :3].max() < 0.01


def test_plans_with_mujoco_itself_as_with_good_equations() -> None:
    robot = replace(CRAZYFLIE, mppi=replace(CRAZYFLIE.mppi, samples=32))
    task = make_task("circle", robot)
    plant = MujocoPlant(robot)
    start = plant.reset(task.start(np.random.default_rng(0)))
    models = (MujocoModel(plant), compile_model(robot.nominal()))
    actions = [MPPI(model, robot, task, backend="torch").act(start, 0) for model in models]  # on the same noise
    np.testing.assert_allclose(*actions, atol=0.02)
