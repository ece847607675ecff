"""The simulated robots against physics that needs no simulator."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
from paper_robots import PAPER_ROBOTS

from sym2real import rotation
from sym2real.effects import effect
from sym2real.errors import ModelError, ShapeError
from sym2real.level_ground import Turn
from sym2real.plants import MujocoPlant
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

INERTIA = np.array([CRAZYFLIE.numbers[name] for name in ("jx", "jy", "jz")])


def flight(state: dict[str, float]) -> Array:
    start = CRAZYFLIE.start.copy()
    for column, value in state.items():
        start[CRAZYFLIE.layouts.state.index(column)] = value
    return start


def quaternion(state: Array) -> torch.Tensor:
    return torch.as_tensor(state[3:7])


def without_actuators() -> MujocoPlant:
    plant = MujocoPlant(CRAZYFLIE)
    plant.mj_model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    return plant


def test_thrust_free_fall_is_a_parabola() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    state = plant.reset(flight({"z": 20.0, "vx": 1.0, "vz": 2.0}))
    for _ in range(50):
        state = plant.step([0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(state[:3], [1.0, 0.0, 20.0 + 2.0 - 0.5 * GRAVITY], atol=1e-9)
    np.testing.assert_allclose(state[7:10], [1.0, 0.0, 2.0 - GRAVITY], atol=1e-9)


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_the_resting_action_holds_the_robot(robot: Robot) -> None:
    plant = MujocoPlant(robot)
    for _ in range(200):
        state = plant.step(robot.rest)
    np.testing.assert_allclose(state, robot.start, atol=1e-6)
    assert not plant.crashed


def test_a_tumble_keeps_energy_and_angular_momentum() -> None:
    plant = without_actuators()
    start = flight({"z": 50.0, "wx": 6.0, "wy": 7.0, "wz": 5.0})

    def energy(state: Array) -> float:
        return float(0.5 * INERTIA @ state[10:] ** 2)

    def momentum(state: Array) -> Array:
        return rotation.rotate(quaternion(state), torch.as_tensor(INERTIA * state[10:])).numpy()

    state = plant.reset(start)
    for _ in range(100):
        state = plant.step(np.zeros(4))
    # Unequal moments: the rates themselves must have moved, or the test would hold for a frozen body too.
    assert np.abs(state[10:] - start[10:]).max() > 1.0
    assert energy(state) == pytest.approx(energy(start), rel=1e-8)
    turned = 1e-8 if mujoco.mj_version() >= 4_000_000 else 1e-5  # versions before turn quaternions less exactly
    np.testing.assert_allclose(momentum(state), momentum(start), rtol=turned)


def test_the_rate_loop_answers_exponentially_about_each_body_axis() -> None:
    for axis, gain in enumerate((50.0, 50.0, 20.0)):
        plant = MujocoPlant(CRAZYFLIE)
        tilted = rotation.from_euler(*torch.tensor([0.5, -0.4, 1.0], dtype=torch.float64)).numpy()
        start = flight({"z": 5.0})
        start[3:7] = tilted
        plant.reset(start)
        command = np.zeros(4)
        command[1 + axis] = 2.0
        state = plant.step(command)
        expected = np.zeros(3)
        expected[axis] = 2.0 * (1.0 - np.exp(-gain * CRAZYFLIE.dt))
        np.testing.assert_allclose(state[10:], expected, atol=1e-5)


def test_the_quaternion_stays_a_unit_one() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    rng = np.random.default_rng(0)
    plant.reset(flight({"z": 30.0}))
    for _ in range(100):
        state = plant.step(rng.uniform(CRAZYFLIE.limits.random_low, CRAZYFLIE.limits.random_high))
        assert float(quaternion(state).norm()) == pytest.approx(1.0, abs=1e-12)


def turned(robot: Robot, state: Array, yaw: float) -> Array:
    """The same state in a world turned by ``yaw`` about its vertical."""
    return Turn(yaw).of_rows(state[None], robot.layouts.state)[0]


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_turning_the_world_turns_the_result(robot: Robot) -> None:
    rng = np.random.default_rng(1)
    start = robot.start.copy()
    start[-6:] = rng.normal(size=6) * 0.3
    if robot is CRAZYFLIE:
        start[2] = 5.0
    else:
        start[2:4] = np.sin(0.3), np.cos(0.3)
        start[-3:] = 0.0
    actions = 0.5 * rng.uniform(robot.limits.random_low, robot.limits.random_high, (20, len(robot.low)))
    actions[:, robot.layouts.action.size - 1] = np.abs(actions[:, -1])
    ends = []
    for yaw in (0.0, 2.0):
        plant = MujocoPlant(robot)
        plant.reset(turned(robot, start, yaw))
        for action in actions:
            state = plant.step(action)
        ends.append(turned(robot, state, -yaw))
    # MuJoCo's contact solver stops at a tolerance; a free body has no such limit.
    difference = np.abs(ends[0] - ends[1])
    if robot is CRAZYFLIE:  # q and -q are one attitude
        difference[3:7] = np.minimum(difference[3:7], np.abs(ends[0] + ends[1])[3:7])
    assert difference.max() < (1e-8 if robot is CRAZYFLIE else 1e-3)


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_equal_actions_give_equal_states(robot: Robot) -> None:
    rng = np.random.default_rng(2)
    actions = rng.uniform(robot.limits.random_low, robot.limits.random_high, (20, len(robot.low)))
    one, other = MujocoPlant(robot), MujocoPlant(robot)
    other.step(robot.high)
    other.reset()
    for action in actions:
        np.testing.assert_array_equal(one.step(action), other.step(action))


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_a_reset_puts_the_plant_where_it_was_told(robot: Robot) -> None:
    start = robot.start + 0.1
    start = robot.layouts.state.normalise(torch.as_tensor(start)).numpy()
    np.testing.assert_allclose(MujocoPlant(robot).reset(start), start, atol=1e-12)


@pytest.mark.parametrize("steer", [0.1, 0.2, -0.38])
def test_the_car_turns_on_the_circle_of_its_steering(steer: float) -> None:
    plant = MujocoPlant(MUSHR)
    states = np.array([plant.step([steer, 0.5]) for _ in range(300)])[100:]
    radius = MUSHR.numbers["wheelbase"] / np.tan(abs(steer))
    centred = states[:, :2] - 0.5 * (states[:, :2].max(0) + states[:, :2].min(0))
    if np.ptp(np.unwrap(np.arctan2(states[:, 2], states[:, 3]))) > 2 * np.pi:
        np.testing.assert_allclose(np.linalg.norm(centred, axis=1), radius, rtol=0.01)
    speed = np.linalg.norm(states[:, 4:6], axis=1)
    np.testing.assert_allclose(speed / np.abs(states[:, 6]), radius, rtol=0.005)
    assert (np.sign(states[:, 6]) == np.sign(steer)).all()


@pytest.mark.parametrize(("speed", "rate"), [(1.5, 0.0), (-1.0, 0.0), (0.8, 0.8)])
def test_a_car_reset_at_speed_rolls_on(speed: float, rate: float) -> None:
    plant = MujocoPlant(MUSHR)
    heading = 0.7
    start = [0.0, 0.0, np.sin(heading), np.cos(heading), speed * np.cos(heading), speed * np.sin(heading), rate]
    plant.reset(start)
    height = plant.mj_data.qpos[2]
    steer = np.arctan(MUSHR.numbers["wheelbase"] * rate / speed)
    state = plant.step([steer, speed])
    assert np.hypot(*state[4:6]) == pytest.approx(abs(speed), rel=0.03)
    assert state[6] == pytest.approx(rate, abs=0.05)
    assert plant.mj_data.qpos[2] == pytest.approx(height, abs=1e-4)


def test_touching_the_ground_ends_a_flight_and_rolling_over_a_drive() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    plant.reset(flight({"z": 0.1}))
    steps = 0
    while not plant.crashed:
        plant.step(np.zeros(4))
        steps += 1
    # The hull's underside is 12 mm below the origin.
    assert steps == np.ceil(np.sqrt(2 * 0.088 / GRAVITY) / CRAZYFLIE.dt)
    plant.reset()
    assert not plant.crashed

    car = MujocoPlant(MUSHR)
    car.mj_data.qvel[2:4] = 2.0, 8.0  # thrown up and rolled
    for _ in range(20):
        car.step(np.zeros(2))
    assert car.crashed


def test_the_crash_stays_known_after_a_bounce() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    plant.reset(flight({"z": 0.02, "vz": -1.0}))
    plant.step(np.zeros(4))
    for _ in range(25):
        plant.step([0.6, 0.0, 0.0, 0.0])
    assert plant.mj_data.ncon == 0
    assert plant.crashed


def test_wrong_shapes_are_refused() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    with pytest.raises(ShapeError, match="wx_cmd"):
        plant.step([0.0, 0.0])
    with pytest.raises(ShapeError, match="fx"):
        plant.push([0.0])
    with pytest.raises(ShapeError, match="qw"):
        plant.reset([0.0, 1.0])


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_the_full_state_brings_everything_back(robot: Robot) -> None:
    plant = MujocoPlant(robot)
    rng = np.random.default_rng(3)
    actions = rng.uniform(robot.limits.random_low, robot.limits.random_high, (10, len(robot.low)))
    for action in actions[:5]:
        plant.step(action)
    kept = plant.full_state
    first = [plant.step(action) for action in actions[5:]]
    plant.full_state = kept
    again = [plant.step(action) for action in actions[5:]]
    # The contact solver's warm start is no physics state; it moves the answer within the solver's tolerance.
    np.testing.assert_allclose(first, again, atol=1e-12 if robot is CRAZYFLIE else 1e-5)


@pytest.mark.parametrize("force", [1e9, -1e299])
def test_a_simulation_that_leaves_all_measure_is_an_error(
    force: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    plant = MujocoPlant(CRAZYFLIE, [effect("wind", CRAZYFLIE).inject(fx=force)])
    with pytest.raises(ModelError, match=r"wind .*expected a crazyflie that can be simulated, found accelerations"):
        plant.step(CRAZYFLIE.low)
    assert not list(tmp_path.iterdir())  # MuJoCo's own log of warnings
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("rate", [45.0, 70.0, 16.0])
def test_a_robot_at_another_period_keeps_time(rate: float) -> None:
    """Free fall, commanded at a rate that is no whole number of its own physics steps."""
    plant = MujocoPlant(CRAZYFLIE.at_period(1.0 / rate))
    start = plant.reset()
    steps = round(0.2 * rate)
    for _ in range(steps):
        state = plant.step(np.zeros(len(plant.layouts.action)))
    seconds = steps / rate
    assert plant.time == pytest.approx(seconds, rel=1e-9)
    assert state[plant.layouts.state.index("vz")] == pytest.approx(-GRAVITY * seconds, rel=2e-2)
    assert state[plant.layouts.state.index("z")] < start[plant.layouts.state.index("z")]
