"""Equations as a plant: what has memory goes on from step to step as it does over a whole log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from sym2real.cli import main
from sym2real.diagnosis import add, compare
from sym2real.effects.filters import filter_commands
from sym2real.effects.sensors import MeasuredModel
from sym2real.errors import ModelError
from sym2real.logs import read_log
from sym2real.plants import EquationsPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot, quadrotor
from sym2real.symbolic import Equations, save_model
from sym2real.trajectory import Array

STEPS = 30
HIGH = CRAZYFLIE.start + np.array([0.0, 0.0, 2.0, *np.zeros(10)])
CASES = {
    "filters": (CRAZYFLIE, {"delay": 0.047, "lag:thrust": 0.06}),
    "hidden states": (CRAZYFLIE, {"motor_lag": 0.05}),
    "time": (CRAZYFLIE, {"battery_sag": 0.05}),
    "all of them": (CRAZYFLIE, {"motor_lag": 0.05, "delay": 0.03, "battery_sag": 0.05}),
    "sensors": (MUSHR, {"yaw_bias": 0.1, "rate_limit:speed": 2.0}),
}


def changed(robot: Robot, values: dict[str, float]) -> Equations:
    equations = robot.nominal()
    for key, value in values.items():
        equations = add(equations, key, {"value": value})
    return equations


def commands(robot: Robot) -> Array:
    rng = np.random.default_rng(3)
    return 0.5 * (robot.rest + rng.uniform(robot.limits.random_low, robot.limits.random_high, (STEPS, len(robot.low))))


@pytest.mark.parametrize("case", CASES)
def test_stepping_is_the_rollout_over_the_whole_log(case: str) -> None:
    robot, values = CASES[case]
    equations, actions = changed(robot, values), commands(robot)
    plant = EquationsPlant(equations, robot)
    rng = np.random.default_rng(1)
    pushes = rng.normal(0.0, 0.01, (STEPS, len(robot.layouts.inputs)))
    for _ in range(2):  # a second episode begins with an empty memory
        first = plant.reset(HIGH if robot is CRAZYFLIE else robot.start)
        states = []
        for action, push in zip(actions, pushes, strict=True):
            plant.push(push)
            states.append(plant.step(action))
    time = equations.dt * np.arange(STEPS)[:, None]
    known = dict(zip((*robot.layouts.inputs, "t"), np.concatenate([pushes, time], axis=1).T, strict=True))
    inputs = np.stack([known[name] for name in equations.layouts.inputs], axis=1)
    sent = filter_commands(equations, torch.as_tensor(actions))
    expected = MeasuredModel(equations).rollout(torch.as_tensor(first), sent, torch.as_tensor(inputs)).numpy()
    np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-9)
    # Without the effects it is another motion.
    plain = EquationsPlant(robot.nominal(), robot)
    plain.reset(HIGH if robot is CRAZYFLIE else robot.start)
    assert np.abs(np.array([plain.step(action) for action in actions]) - states).max() > 1e-3


def test_a_delay_answers_that_many_steps_later() -> None:
    plant = EquationsPlant(changed(MUSHR, {"delay": 3 * MUSHR.dt}), MUSHR)
    plant.reset()
    states = [plant.step([0.0, 0.0])] + [plant.step([0.0, 1.0]) for _ in range(6)]
    moving = [abs(state[0]) > 1e-6 for state in states]
    assert moving == [False, False, False, False, True, True, True]


@pytest.mark.parametrize("key", ["sensor_lag:x", "time_shift:x"])
def test_what_is_measured_late_is_refused(key: str) -> None:
    with pytest.raises(ModelError, match=key):
        EquationsPlant(changed(CRAZYFLIE, {key: 0.04}), CRAZYFLIE)


@pytest.mark.parametrize(
    ("equations", "said"), [(quadrotor(0.03, interface="motors"), "motor1"), (MUSHR.nominal(), "sin_yaw")]
)
def test_a_model_of_other_columns_is_refused(equations: Equations, said: str) -> None:
    with pytest.raises(ModelError, match=f"crazyflie's columns .*found .*{said}"):
        EquationsPlant(equations, CRAZYFLIE)


def test_run_drives_a_found_model_with_its_delay(tmp_path: Path) -> None:
    late = changed(MUSHR, {"delay": 3 * MUSHR.dt})
    save_model(late, tmp_path / "found")
    arguments = ["run", str(tmp_path / "found"), "circle", "--plant", "model", "--seconds", "4", "--samples", "64"]
    main([*arguments, "--out", str(tmp_path / "flown")])
    log = read_log(tmp_path / "flown" / "circle.csv")
    errors = [
        compare(model, log, start="measured").at(0.5).errors["position"].value for model in (late, MUSHR.nominal())
    ]
    assert errors[0] < 1e-3
    assert errors[1] > 0.01
