"""What every registered robot must offer, and the way between states and coordinates."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch
from paper_robots import PAPER_ROBOTS

from sym2real.errors import ShapeError, UnknownNameError
from sym2real.plants.mujoco_plant import compile_robot
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.robots.mushr import MOVED_MASS, ackermann

every_robot = pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)


@every_robot
def test_numbers_of_a_robot_agree_with_its_description(robot: Robot) -> None:
    model = compile_robot(robot)
    assert model.opt.timestep == pytest.approx(robot.description.physics_dt)
    assert robot.substeps * robot.description.physics_dt == pytest.approx(robot.dt, rel=1e-12)
    assert model.body_mass.sum() == pytest.approx(robot.mass)
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, robot.name) == 1
    # The commands' whole range passes the actuators unclipped.
    for corner in (robot.low, robot.high, robot.rest, robot.limits.random_low, robot.limits.random_high):
        control = robot.description.to_control(corner)
        assert control.shape == (model.nu,)
        assert (control >= model.actuator_ctrlrange[:, 0] - 1e-12).all()
        assert (control <= model.actuator_ctrlrange[:, 1] + 1e-12).all()


def test_inertia_and_rate_gains_of_the_crazyflie_are_those_of_its_description() -> None:
    model = compile_robot(CRAZYFLIE)
    inertia = np.array([CRAZYFLIE.numbers[name] for name in ("jx", "jy", "jz")])
    gains = np.array([CRAZYFLIE.numbers[name] for name in ("kx", "ky", "kz")])
    np.testing.assert_allclose(model.body_inertia[1], inertia)
    np.testing.assert_allclose(model.actuator_gainprm[1:, 0], inertia * gains)
    np.testing.assert_allclose(model.actuator_biasprm[1:, 2], -inertia * gains)


def test_wheels_of_the_car_are_where_its_constants_say() -> None:
    model = compile_robot(MUSHR)
    wheels = {name: model.body(name).pos for name in ("front_left", "front_right", "rear_left", "rear_right")}
    assert wheels["front_left"][0] - wheels["rear_left"][0] == pytest.approx(MUSHR.numbers["wheelbase"])
    assert wheels["front_left"][1] - wheels["front_right"][1] == pytest.approx(MUSHR.numbers["track"])
    assert model.geom("rear_left").size.max() == pytest.approx(MUSHR.numbers["wheel_radius"])
    spin = model.body("rear_left").inertia.max() / MUSHR.numbers["wheel_radius"] ** 2
    assert pytest.approx(MUSHR.mass + 4 * spin) == MOVED_MASS


@every_robot
def test_states_survive_the_way_through_coordinates(robot: Robot) -> None:
    model = compile_robot(robot)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    for _ in range(10):
        state = robot.layouts.state.normalise(torch.as_tensor(rng.normal(size=robot.layouts.state.size))).numpy()
        robot.write_state(data, state)
        np.testing.assert_allclose(robot.read_state(data), state, atol=1e-12)
    batch = robot.description.to_state(np.tile(data.qpos, (2, 3, 1)), np.tile(data.qvel, (2, 3, 1)))
    assert batch.shape == (2, 3, robot.layouts.state.size)
    np.testing.assert_allclose(batch[1, 2], state, atol=1e-12)


@every_robot
def test_controls_of_a_batch_are_those_of_its_rows(robot: Robot) -> None:
    actions = np.random.default_rng(0).uniform(robot.low, robot.high, (4, 5, len(robot.low)))
    batch = robot.description.to_control(actions)
    np.testing.assert_array_equal(batch[3, 2], robot.description.to_control(actions[3, 2]))


@every_robot
def test_a_robot_names_only_columns_that_it_has(robot: Robot) -> None:
    for state, action in robot.recipe.dependencies:
        assert state in robot.layouts.state
        assert action in robot.layouts.action
    assert {action for _, action in robot.recipe.dependencies} == set(robot.layouts.action)
    assert tuple(robot.limits.push) == robot.layouts.inputs.columns
    assert set(robot.recipe.cost_weights) == {"position", "orientation", "velocity", "rate"}
    assert len(robot.mppi.noise) == robot.layouts.action.size
    assert set(robot.recipe.angles) <= {*robot.layouts.state, *robot.layouts.action}
    assert (robot.limits.random_low >= robot.low).all()
    assert (robot.limits.random_high <= robot.high).all()


def test_front_wheels_share_one_turning_centre() -> None:
    for steer in (-0.38, 0.2, 0.38):
        left, right = ackermann(np.array(steer))
        length, track = MUSHR.numbers["wheelbase"], MUSHR.numbers["track"]
        # The lines through both front wheels' axes meet on the rear axle's line, at the bicycle's centre.
        assert track / 2 + length / np.tan(left) == pytest.approx(length / np.tan(steer))
        assert -track / 2 + length / np.tan(right) == pytest.approx(length / np.tan(steer))


@every_robot
def test_at_a_longer_period_the_equations_have_it_too(robot: Robot) -> None:
    slow, nominal = robot.at_period(3 * robot.dt).nominal(), robot.nominal()
    assert (nominal.dt, slow.dt) == (pytest.approx(robot.dt), pytest.approx(3 * robot.dt))
    action = robot.rest * 1.05 + 0.05
    state = robot.start
    for _ in range(3):
        state = nominal.predict(state, action)
    np.testing.assert_allclose(slow.predict(robot.start, action), state, atol=1e-12)


def test_wrong_names_and_sizes_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="crazyflie"):
        ROBOTS["crazyfly"]
    with pytest.raises(ShapeError, match="low needs 4"):
        CRAZYFLIE.within(np.zeros(3), CRAZYFLIE.high)
    with pytest.raises(ShapeError, match="start needs 7"):
        replace(MUSHR, description=replace(MUSHR.description, start=np.zeros(3)))
