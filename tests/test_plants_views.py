"""Batched rollouts, models as plants, episodes, random pushes and the Gymnasium view."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env
from paper_robots import PAPER_ROBOTS

from sym2real.effects import effect
from sym2real.errors import ModelError, ShapeError
from sym2real.plants import (
    ModelPlant,
    MujocoPlant,
    random_wrench,
    rollout_mujoco,
    run_episode,
)
from sym2real.plants.gymnasium_view import TaskEnvironment
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.symbolic import compile_model
from sym2real.tasks import make_task
from sym2real.trajectory import Array

every_robot = pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)


class Scripted:
    """A controller that plays a list of actions and keeps what it was told."""

    def __init__(self, actions: Array) -> None:
        self.actions = actions
        self.sent: list[Array] = []
        self.inputs: list[Array] = []

    def reset(self) -> None:
        self.sent.clear()
        self.inputs.clear()

    def act(self, state: Any, step: int, inputs: Any = None) -> Array:
        self.inputs.append(np.asarray(inputs))
        action: Array = self.actions[step]
        return action

    def remember(self, sent: Any) -> None:
        self.sent.append(np.asarray(sent))


def draw(robot: Robot, steps: int, seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    return 0.5 * (robot.rest + rng.uniform(robot.limits.random_low, robot.limits.random_high, (steps, len(robot.low))))


def high(robot: Robot) -> Array:
    start = robot.start.copy()
    if robot is CRAZYFLIE:
        start[2] = 5.0
    return start


@every_robot
def test_a_rollout_is_what_stepping_gives(robot: Robot) -> None:
    changes = [effect("slope", MUSHR).inject(gx=0.3, gy=0.1)]
    plant = MujocoPlant(robot, changes)
    plant.reset(high(robot))
    for action in draw(robot, 5, seed=9):
        plant.step(action)
    start = plant.full_state
    actions = np.stack([draw(robot, 8, seed) for seed in range(4)])
    batch = rollout_mujoco(plant, start, actions)
    np.testing.assert_array_equal(plant.full_state, start)
    for index, sequence in enumerate(actions):
        plant.full_state = start
        stepped = [plant.step(action) for action in sequence]
        np.testing.assert_allclose(batch[index], stepped, atol=1e-10 if robot is CRAZYFLIE else 1e-4)


def test_rollouts_start_where_each_is_told() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    starts = []
    for height in (2.0, 3.0):
        start = CRAZYFLIE.start.copy()
        start[2] = height
        plant.reset(start)
        starts.append(plant.full_state)
    states = rollout_mujoco(plant, np.array(starts), np.tile(CRAZYFLIE.rest, (2, 3, 1)))
    np.testing.assert_allclose(states[:, :, 2], [[2.0] * 3, [3.0] * 3], atol=1e-9)


def test_coarse_rollouts_of_a_free_body_stay_close() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    plant.reset(high(CRAZYFLIE))
    actions = np.stack([draw(CRAZYFLIE, 40, seed) for seed in range(4)])
    fine = rollout_mujoco(plant, plant.full_state, actions)
    coarse = rollout_mujoco(plant, plant.full_state, actions, substeps=2)
    assert 0.0 < np.abs(fine - coarse)[..., :3].max() < 1e-4
    assert plant.mj_model.opt.timestep == CRAZYFLIE.description.physics_dt


def test_rollouts_and_episodes_of_nothing_are_refused() -> None:
    plant, controller = MujocoPlant(CRAZYFLIE), Scripted(np.zeros((3, 4)))
    for shape in ((0, 3, 4), (2, 3, 3), (3, 4)):
        with pytest.raises(ShapeError, match="with N > 0"):
            rollout_mujoco(plant, plant.full_state, np.zeros(shape))
    with pytest.raises(ShapeError, match="at least one physics step"):
        rollout_mujoco(plant, plant.full_state, np.zeros((2, 3, 4)), substeps=0)
    with pytest.raises(ShapeError, match="at least one step"):
        run_episode(plant, controller, steps=0)
    with pytest.raises(ShapeError, match="found 3 steps and 2 wrenches"):
        run_episode(plant, controller, steps=3, wrench=np.zeros((2, 6)))


@every_robot
def test_what_is_no_number_never_reaches_the_simulator(robot: Robot) -> None:
    """MuJoCo would put zeros in its place and go on."""
    plant = MujocoPlant(robot)
    with pytest.raises(ShapeError, match="finite action"):
        plant.step(np.full(robot.layouts.action.size, np.nan))
    with pytest.raises(ShapeError, match="finite state"):
        plant.reset(np.full(robot.layouts.state.size, np.inf))


def test_rollouts_refuse_what_they_cannot_apply() -> None:
    actions = np.tile(CRAZYFLIE.rest, (2, 3, 1))
    windy = MujocoPlant(CRAZYFLIE, [effect("wind", CRAZYFLIE).inject(fx=0.01)])
    with pytest.raises(ModelError, match=r"wind fx 0\.01"):
        rollout_mujoco(windy, windy.full_state, actions)
    plant = MujocoPlant(CRAZYFLIE)
    with pytest.raises(ShapeError, match="full states"):
        rollout_mujoco(plant, plant.full_state[:-1], actions)
    plant.push([0.01, 0, 0, 0, 0, 0])
    with pytest.raises(ModelError, match="wrench"):
        rollout_mujoco(plant, plant.full_state, actions)


@every_robot
def test_an_episode_is_a_log_whose_rows_answer_each_other(robot: Robot) -> None:
    actions = draw(robot, 30)
    pushes = random_wrench(robot, 30, np.random.default_rng(0))
    controller = Scripted(actions)
    log = run_episode(MujocoPlant(robot), controller, start=high(robot), steps=30, wrench=pushes, name="one")
    assert len(log) == 30
    assert log.dt == pytest.approx(robot.dt)
    np.testing.assert_array_equal(log.action, actions)
    np.testing.assert_array_equal(log.inputs, pushes)
    np.testing.assert_array_equal(controller.sent, actions)
    np.testing.assert_array_equal(controller.inputs, pushes)
    again = MujocoPlant(robot)
    np.testing.assert_array_equal(log.state[0], again.reset(high(robot)))
    for row in range(29):
        again.push(pushes[row])
        np.testing.assert_array_equal(log.state[row + 1], again.step(actions[row]))


def test_a_crash_ends_an_episode_before_its_traces_are_written() -> None:
    plant = MujocoPlant(CRAZYFLIE)
    rows: list[int] = []
    log = run_episode(plant, Scripted(np.zeros((400, 4))), on_step=lambda step, state, action: rows.append(step))
    # From 1 m down to the hull's 12 mm, in free fall.
    assert len(log) == np.ceil(np.sqrt(2 * 0.988 / 9.81) / 0.02) == len(rows)
    np.testing.assert_allclose(log.column("vz"), -9.81 * log.time, atol=1e-9)
    assert log.notes == ("ended by a crash",)


def test_an_episode_of_a_task_starts_there_and_carries_its_reference() -> None:
    task = make_task("circle", MUSHR)
    log = run_episode(MujocoPlant(MUSHR), Scripted(draw(MUSHR, 10)), task, seed=3, steps=10)
    np.testing.assert_allclose(log.state[0], task.start(np.random.default_rng(3)), atol=1e-12)
    reference = task.reference(torch.as_tensor(log.time)).numpy()
    for index, column in enumerate(MUSHR.layouts.state):
        np.testing.assert_array_equal(log.column(f"ref_{column}"), reference[:, index])


@every_robot
def test_pushes_are_smooth_bounded_random_and_repeatable(robot: Robot) -> None:
    pushes = random_wrench(robot, 2000, np.random.default_rng(0))
    np.testing.assert_array_equal(pushes, random_wrench(robot, 2000, np.random.default_rng(0)))
    limits = np.array([robot.limits.push[column] for column in robot.layouts.inputs])
    share = pushes / limits
    forces = [robot.layouts.inputs.index(column) for column in robot.layouts.inputs if column.startswith("f")]
    assert np.linalg.norm(share[:, forces], axis=1).max() < 1.0
    assert np.abs(share).max() < 1.0
    # Used in full, about zero, and smooth: from one control step to the next a fraction of the spread.
    assert (share.std(axis=0) > 0.35).all()
    assert (np.abs(share.mean(axis=0)) < 0.3).all()
    assert (np.diff(share, axis=0).std(axis=0) < 0.15 * share.std(axis=0)).all()


@pytest.mark.parametrize("name", ["cart_pole", "arm", "differential_drive"])
def test_pushes_along_joints_stay_within_their_limits(name: str) -> None:
    """Each alone: no push belongs to another, whatever letters their names begin with."""
    robot = ROBOTS[name]
    share = random_wrench(robot, 5000, np.random.default_rng(0)) / [*map(robot.limits.push.get, robot.layouts.inputs)]
    assert (np.abs(share).max(axis=0) > 0.8).all()
    assert np.abs(share).max() < 1.0


def test_the_car_forgets_no_wrench_limits() -> None:
    assert MUSHR.limits.push["fx"] == pytest.approx(0.3 * 3.5 * 9.81)
    assert CRAZYFLIE.limits.push["tx"] == pytest.approx(0.5 * 1.66e-5 * 50 * 8)


@every_robot
def test_a_model_as_plant_steps_the_model(robot: Robot) -> None:
    model = compile_model(robot.nominal(), dtype=torch.float64)
    plant = ModelPlant(model, robot)
    actions, pushes = draw(robot, 20), random_wrench(robot, 20, np.random.default_rng(1))
    log = run_episode(plant, Scripted(actions), start=high(robot), steps=20, wrench=pushes)
    expected = model.rollout(*(torch.as_tensor(values) for values in (log.state[0], actions, pushes))).numpy()
    np.testing.assert_allclose(log.state[1:], expected[:-1], atol=1e-10)


@every_robot
def test_logs_and_controllers_hear_what_was_sent_not_what_was_asked(robot: Robot) -> None:
    asked = robot.rest + 2.0 * (robot.high - robot.rest) * np.sin(np.arange(30.0))[:, None]
    sent = np.clip(asked, robot.low, robot.high)
    assert (asked != sent).any()
    controller, heard = Scripted(asked), list[Array]()
    log = run_episode(
        MujocoPlant(robot),
        controller,
        start=high(robot),
        steps=30,
        on_step=lambda step, state, action: heard.append(action),
    )
    rows = len(log)
    for told in (log.action, controller.sent, heard):
        np.testing.assert_array_equal(told, sent[:rows])
    within = run_episode(MujocoPlant(robot), Scripted(sent), start=high(robot), steps=30)
    np.testing.assert_array_equal(log.state, within.state)


@every_robot
def test_a_command_is_sent_before_the_robots_own_filters(robot: Robot) -> None:
    late = MujocoPlant(robot, [effect("delay", robot).inject(value=2 * robot.dt)])
    for action in draw(robot, 4):
        late.step(action)
        np.testing.assert_array_equal(late.sent, action)
    late.reset()
    assert np.isnan(late.sent).all()  # nothing was sent yet


def test_any_callable_is_a_plant_and_its_result_is_put_on_the_manifold() -> None:
    plant = ModelPlant(lambda state, action, inputs=None: state + torch.ones(7), MUSHR)
    state = plant.step([0.0, 0.0])
    np.testing.assert_allclose(state[:4], [1.0, 1.0, *(np.array([1.0, 2.0]) / np.sqrt(5.0))])
    with pytest.raises(ShapeError, match="speed"):
        plant.step([0.0])


def test_a_model_as_plant_crashes_below_the_ground_and_beyond_numbers() -> None:
    plant = ModelPlant(compile_model(CRAZYFLIE.nominal()), CRAZYFLIE)
    assert not plant.crashed
    while not plant.crashed:
        state = plant.step(np.zeros(4))
    assert state[2] < 0.0
    diverging = ModelPlant(lambda state, action, inputs=None: state * torch.nan, CRAZYFLIE)
    diverging.step(CRAZYFLIE.rest)
    assert diverging.crashed


@pytest.mark.filterwarnings("ignore:.*Box observation space m:UserWarning", "ignore:.*Box action space:UserWarning")
@every_robot
def test_the_gymnasium_view_passes_gymnasiums_own_check(robot: Robot) -> None:
    task = make_task("hover" if robot is CRAZYFLIE else "park", robot)
    check_env(TaskEnvironment(MujocoPlant(robot), task), skip_render_check=True)
    check_env(TaskEnvironment(ModelPlant(compile_model(robot.nominal()), robot), task), skip_render_check=True)


def test_the_gymnasium_view_rewards_minus_the_cost_and_ends_where_it_must() -> None:
    task = make_task("hover", CRAZYFLIE)
    view: gymnasium.Env[Any, Any] = TaskEnvironment(MujocoPlant(CRAZYFLIE), task)
    observation, _ = view.reset(seed=1)
    steps, done, total = 0, False, []
    while not done:
        observation, reward, terminated, truncated, info = view.step(CRAZYFLIE.rest)
        np.testing.assert_array_equal(info["sent"], CRAZYFLIE.rest)
        total.append(reward)
        steps += 1
        done = terminated or truncated
    assert truncated
    assert not terminated
    assert steps == round(task.duration / CRAZYFLIE.dt)
    # Held where the task starts, the cost is that of the distance to the goal, by eq. (5) written out.
    goal = task.reference(torch.tensor(steps * CRAZYFLIE.dt, dtype=torch.float64)).numpy()
    weights = CRAZYFLIE.recipe.cost_weights
    expected = (
        weights["position"] * np.linalg.norm(observation[:3] - goal[:3])
        + weights["orientation"] * (1 - (observation[3:7] @ goal[3:7]) ** 2)
        + weights["velocity"] * np.linalg.norm(observation[7:10] - goal[7:10])
        + weights["rate"] * np.linalg.norm(observation[10:] - goal[10:])
    )
    assert total[-1] == pytest.approx(-expected, abs=1e-5)

    view.reset(seed=1)
    terminated, truncated = False, False
    while not (terminated or truncated):
        *_, terminated, truncated, _ = view.step(np.zeros(4))
    assert terminated


def test_rollouts_hold_the_forces_of_a_steady_wind() -> None:
    plant = MujocoPlant(CRAZYFLIE, [effect("wind", CRAZYFLIE).inject(fx=0.02, fy=-0.01)])
    plant.reset(high(CRAZYFLIE))
    plant.push([0.0, 0.0, 0.01, 1e-6, 0.0, 0.0])
    start, actions = plant.full_state, draw(CRAZYFLIE, 8, seed=3)
    rolled = rollout_mujoco(plant, start, actions[None], forces=plant.forces)[0]
    plant.full_state = start
    np.testing.assert_allclose(rolled[:, :3], [plant.step(action)[:3] for action in actions], atol=1e-5)
