"""First-principles equations against mechanics, and against MuJoCo."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from motor_flights import THRUST, motor_flights
from paper_robots import PAPER_ROBOTS

from sym2real import rotation
from sym2real.control.logged import Replayed
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.effects import effect
from sym2real.effects.along_logs import prepared
from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.plants import MujocoPlant, random_wrench, run_episode
from sym2real.report.tables import interface_lines
from sym2real.robots import CRAZYFLIE, MUSHR, ROBOTS, Robot
from sym2real.robots.crazyflie import ARM, MASS, TORQUE_PER_THRUST
from sym2real.robots.motors import Motors
from sym2real.robots.nominal_car import car
from sym2real.robots.nominal_quadrotor import quadrotor
from sym2real.robots.robot import GRAVITY
from sym2real.robots.thrust_fit import fit_thrust_per_unit
from sym2real.symbolic import Equations, compile_model
from sym2real.symbolic.mass_normalised import PER_KILOGRAM
from sym2real.trajectory import Array, Trajectory

INERTIA = (1.66e-5, 1.67e-5, 2.93e-5)
MOTORS = Motors(thrust=0.15)
QUADROTOR, CAR = CRAZYFLIE.nominal(), MUSHR.nominal()


@functools.cache
def compiled(equations: Equations) -> Any:
    return compile_model(equations, dtype=torch.float64)


def step(equations: Equations, state: Any, action: Any, inputs: Any = None) -> Array:
    tensors = [None if value is None else torch.as_tensor(value, dtype=torch.float64) for value in (action, inputs)]
    result: Array = compiled(equations)(torch.as_tensor(state, dtype=torch.float64), *tensors).numpy()
    return result


def state13(**values: float) -> Array:
    state = np.zeros(13)
    state[3] = 1.0
    for column, value in values.items():
        state[CRAZYFLIE.layouts.state.index(column)] = value
    return state


def simulated(robot: Robot, actions: Array, start: Array, wrench: Array | None = None, changes: Any = ()) -> Array:
    plant = MujocoPlant(robot, changes)
    states = [plant.reset(start)]
    for index, action in enumerate(actions):
        if wrench is not None:
            plant.push(wrench[index])
        states.append(plant.step(action))
    return np.array(states)


def predicted(equations: Equations, start: Array, actions: Array, inputs: Array | None = None) -> Array:
    tensors = [torch.as_tensor(values) for values in (start, actions)]
    held = None if inputs is None else torch.as_tensor(inputs)
    return np.vstack([start, compiled(equations).rollout(*tensors, held).numpy()])


def commands(robot: Robot, scale: float, seed: int) -> Array:
    """Random commands of 0.8 s (car 1 s), each held for 0.2 s, scaled about rest."""
    rng = np.random.default_rng(seed)
    held, steps = round(0.2 / robot.dt), round((0.8 if robot is CRAZYFLIE else 1.0) / robot.dt)
    draws = rng.uniform(robot.limits.random_low, robot.limits.random_high, (steps // held + 1, len(robot.low)))
    result: Array = robot.rest + scale * (np.repeat(draws, held, axis=0)[:steps] - robot.rest)
    return result


def quadrotor_start(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    start = state13(z=20.0)
    start[3:7] = rotation.exponential(torch.as_tensor(rng.normal(size=3) * 0.3)).numpy()
    start[7:] = rng.normal(size=6)
    return start


# Position error at the end of 0.8 s. What is left out of a step is third order in its rotation: starts at 1 rad/s
# (0.02 rad a step) leave a fifth of a millimetre, full rate commands of 8 rad/s (0.16 rad a step) millimetres.
@pytest.mark.parametrize(("scale", "bound"), [(0.02, 4e-4), (0.2, 8e-4), (1.0, 1e-2)])
def test_the_quadrotor_follows_mujoco(scale: float, bound: float) -> None:
    for seed in range(8):
        actions, start = commands(CRAZYFLIE, scale, seed), quadrotor_start(seed)
        truth = simulated(CRAZYFLIE, actions, start)
        path = predicted(QUADROTOR, start, actions)
        assert np.linalg.norm(path[-1, :3] - truth[-1, :3]) < bound
        assert np.abs(path[-1, 10:] - truth[-1, 10:]).max() < max(10 * bound, 1e-2)


def test_the_quadrotor_converges_to_mujoco_at_second_order() -> None:
    errors = []
    for parts in (1, 2, 4):
        equations = quadrotor(0.027, INERTIA, dt=0.02 / parts)
        total = 0.0
        for seed in range(4):
            actions, start = commands(CRAZYFLIE, 1.0, seed), quadrotor_start(seed)
            truth = simulated(CRAZYFLIE, actions, start)
            path = predicted(equations, start, np.repeat(actions, parts, axis=0))
            total += float(np.linalg.norm(path[-1, :3] - truth[-1, :3]))
        errors.append(total)
    assert errors[1] / errors[0] == pytest.approx(0.25, abs=0.02)
    assert errors[2] / errors[1] == pytest.approx(0.25, abs=0.01)


# Straight and gentle: what a kinematic bicycle leaves out is the steering servo (25 ms) and the wheels' softness.
@pytest.mark.parametrize(("scale", "bound"), [(0.1, 2e-3), (0.3, 1e-2)])
def test_the_bicycle_follows_mujoco_at_low_speed(scale: float, bound: float) -> None:
    for seed in range(6):
        actions = commands(MUSHR, scale, seed)
        actions[:, 1] = np.abs(actions[:, 1])
        truth = simulated(MUSHR, actions, MUSHR.start)
        path = predicted(CAR, MUSHR.start, actions)
        assert np.linalg.norm(path[-1, :2] - truth[-1, :2]) < bound


@pytest.mark.parametrize("robot", PAPER_ROBOTS.values(), ids=PAPER_ROBOTS)
def test_the_wrench_moves_the_equations_as_a_push_moves_mujoco(robot: Robot) -> None:
    for seed in range(3):
        wrench = random_wrench(robot, 40, np.random.default_rng(seed))
        if robot is MUSHR:
            wrench[:, 1:] = 0.0  # along the car; across it and about its vertical the tyres hold
        actions = commands(robot, 0.1, seed)
        wrench = wrench[: len(actions)]
        start = quadrotor_start(seed) if robot is CRAZYFLIE else robot.start
        if robot is MUSHR:
            actions[:, 0] = 0.0
        pushed, alone = simulated(robot, actions, start, wrench), simulated(robot, actions, start)
        path = predicted(QUADROTOR if robot is CRAZYFLIE else CAR, start, actions, wrench)
        moved = np.linalg.norm((pushed - alone)[-1, :3])
        assert np.linalg.norm((path - pushed)[-1, :2]) < 0.03 * moved
    assert moved > 0.05


def test_a_moved_centre_of_mass_is_a_torque_of_the_thrust() -> None:
    """τ = -r × T e₃; the position is the frame's, which the turning moves by r: a millimetre."""
    offset = np.array([0.002, 0.001, 0.0])
    actions, start = commands(CRAZYFLIE, 0.1, 0), state13(z=20.0)
    truth = simulated(
        CRAZYFLIE,
        actions,
        start,
        changes=[effect("com_offset", CRAZYFLIE).inject(rx=offset[0], ry=offset[1], rz=offset[2])],
    )
    wrench = np.zeros((len(actions), 6))
    wrench[:, 3:] = [-np.cross(offset, [0.0, 0.0, thrust]) for thrust in actions[:, 0]]
    with_torque = predicted(QUADROTOR, start, actions, wrench)
    without = predicted(QUADROTOR, start, actions)
    assert np.linalg.norm((with_torque - truth)[-1, :3]) < 3e-3
    assert np.linalg.norm((without - truth)[-1, :3]) > 0.1


def test_a_slope_is_a_force_on_the_car() -> None:
    actions = np.tile([0.0, 1.0], (40, 1))
    truth = simulated(MUSHR, actions, MUSHR.start, changes=[effect("slope", MUSHR).inject(gx=-2.0 / MUSHR.mass)])
    wrench = np.tile([-2.0, 0.0, 0.0], (40, 1))
    path = predicted(CAR, MUSHR.start, actions, wrench)
    plain = predicted(CAR, MUSHR.start, actions)
    assert abs((path - truth)[-1, 0]) < 0.1 * abs((plain - truth)[-1, 0])


def test_a_brake_on_a_car_without_a_speed_loop_slows_path_turn_and_speed_alike() -> None:
    """By what it gives in a step; a gain of the speed is the same as a drag there, and an offset as friction."""
    base, steer, speed, dt = car(wheelbase=0.3, mass=2.0, dt=0.05), 0.2, 1.5, 0.05
    state, command = np.array([0.0, 0.0, 0.0, 1.0, speed, 0.0, 0.0]), np.array([steer, speed])
    after = base.predict(state, command, np.array([-4.0, 0.0, 0.0]))
    slower = speed - dt * 4.0 / 2.0
    np.testing.assert_allclose(after, base.predict(state, np.array([steer, slower])), rtol=1e-9)
    assert np.hypot(after[4], after[5]) == pytest.approx(slower)
    assert after[6] == pytest.approx(slower * np.tan(steer) / 0.3)
    assert effect("linear_drag", base).stood_for_by == "gain:speed"
    assert "offset" in effect("rolling_resistance", base).searching.why_not(effect("rolling_resistance", base).body)
    looped = car(wheelbase=0.3, mass=2.0, dt=0.05, time_constant=0.1)
    assert effect("linear_drag", looped).stood_for_by == ""


def test_free_fall_and_hover() -> None:
    equations = quadrotor(1.3, dt=0.05)
    fallen = step(equations, state13(z=5.0, vx=1.0), [0.0, 0.0, 0.0, 0.0])
    assert fallen[0] == pytest.approx(0.05)
    assert fallen[2] == pytest.approx(5.0 - 0.5 * GRAVITY * 0.05**2)
    assert fallen[9] == pytest.approx(-GRAVITY * 0.05)
    np.testing.assert_allclose(step(equations, state13(z=5.0), [1.3 * GRAVITY, 0, 0, 0]), state13(z=5.0), atol=1e-12)


def test_a_tumble_keeps_energy_and_angular_momentum() -> None:
    """Motors still, no rate loop: what Euler's equations conserve, the mid-point rule does to second order."""
    state = torch.as_tensor(state13(wx=3.0, wy=4.0, wz=2.0))
    inertia = torch.tensor(INERTIA, dtype=torch.float64)
    model = compiled(quadrotor(0.027, INERTIA, interface="motors", motors=MOTORS, dt=0.002))
    end = model.rollout(state, torch.zeros(1000, 4, dtype=torch.float64))[-1]

    def momentum(s: torch.Tensor) -> torch.Tensor:
        return rotation.rotate(s[3:7], inertia * s[10:])

    assert (end[10:] - state[10:]).abs().max() > 1.0
    assert float((inertia * end[10:] ** 2).sum() / (inertia * state[10:] ** 2).sum()) == pytest.approx(1.0, abs=1e-4)
    torch.testing.assert_close(momentum(end), momentum(state), rtol=1e-4, atol=1e-9)


def test_turning_the_world_turns_the_prediction() -> None:
    start, actions = quadrotor_start(4), commands(CRAZYFLIE, 1.0, 4)
    about_z = torch.tensor([np.cos(1.0), 0.0, 0.0, np.sin(1.0)], dtype=torch.float64)

    def turn(state: Array) -> Array:
        s = torch.as_tensor(state)
        parts = [rotation.rotate(about_z, s[..., :3]), rotation.multiply(about_z, s[..., 3:7])]
        return torch.cat([*parts, rotation.rotate(about_z, s[..., 7:10]), s[..., 10:]], -1).numpy()

    model = QUADROTOR
    np.testing.assert_allclose(
        predicted(model, turn(start), actions), turn(predicted(model, start, actions)), atol=1e-9
    )


def test_motors_give_the_thrust_and_torques_of_their_places() -> None:
    equations = quadrotor(0.027, INERTIA, interface="motors", motors=MOTORS)
    hover = MOTORS.hover(0.027 * GRAVITY)
    np.testing.assert_allclose(step(equations, state13(z=1.0), [hover] * 4), state13(z=1.0), atol=1e-12)
    lever = 0.046 / np.sqrt(2)
    for pattern, column, arm in (
        ([-1, -1, 1, 1], "wx", lever),  # left rotors roll to the right: positive about x forward
        ([-1, 1, 1, -1], "wy", lever),  # back rotors push the nose down: positive about y left
        ([-1, 1, -1, 1], "wz", MOTORS.torque_per_thrust),
    ):
        after = step(equations, state13(z=1.0), hover + 0.01 * np.array(pattern))
        axis = "xyz".index(column[1])
        expected = 4 * 0.01 * MOTORS.thrust * arm / INERTIA[axis] * 0.02
        assert after[CRAZYFLIE.layouts.state.index(column)] == pytest.approx(expected, rel=1e-6)


def test_speeds_push_as_commands_for_their_squares_do() -> None:
    by_speed = quadrotor(0.03, INERTIA, interface="motors", motors=Motors(thrust=2e-8, unit="rad/s"))
    by_command = quadrotor(0.03, INERTIA, interface="motors", motors=Motors(thrust=2e-8 * 2500.0**2))
    command = np.array([0.7, 0.71, 0.69, 0.72])
    state = quadrotor_start(2)
    pushed = step(by_command, state, command**2)
    np.testing.assert_allclose(step(by_speed, state, 2500.0 * command), pushed, rtol=1e-9)
    for motors in (Motors(2e-8, "rad/s"), MOTORS):
        assert 4 * motors.forces([motors.hover(0.3)])[0] == pytest.approx(0.3)


def test_motors_that_make_the_rate_loops_torques_are_the_rate_loop() -> None:
    """Thrust and torque of a rate loop, allocated to motors every millisecond, against the loop in one step."""
    rates = quadrotor(0.027, INERTIA, dt=0.02)
    motors = compiled(quadrotor(0.027, INERTIA, interface="motors", motors=MOTORS, dt=0.0005))
    lever = MOTORS.arm / np.sqrt(2)
    allocation = np.array(
        [
            [1, 1, 1, 1],
            [-lever, -lever, lever, lever],
            [-lever, lever, lever, -lever],
            MOTORS.torque_per_thrust * np.array([-1, 1, -1, 1]),
        ]
    )
    action, start = np.array([0.3, 2.0, -1.0, 0.5]), quadrotor_start(5)
    state = torch.as_tensor(start)
    for _ in range(40):
        torque = np.array(INERTIA) * [50.0, 50.0, 20.0] * (action[1:] - state[10:].numpy())
        command = np.linalg.solve(allocation, [action[0], *torque]) / MOTORS.thrust
        state = motors(state, torch.as_tensor(command))
    np.testing.assert_allclose(step(rates, start, action), state.numpy(), atol=2e-2)
    np.testing.assert_allclose(step(rates, start, action)[:10], state.numpy()[:10], atol=1e-3)


@pytest.mark.parametrize("interface", ["thrust_rates", "thrust_attitude", "motors"])
def test_measured_attitude_predicts_what_predicted_attitude_does_where_it_is_held(interface: Any) -> None:
    measured = quadrotor(0.027, INERTIA, interface=interface, attitude="measured", motors=MOTORS)
    full = quadrotor(0.027, INERTIA, interface=interface, motors=MOTORS)
    assert measured.layouts.state.columns == ("x", "y", "z", "vx", "vy", "vz")
    assert not any("w" in column for column in measured.layouts.state)
    attitude = rotation.from_euler(*torch.tensor([0.3, -0.2, 0.7], dtype=torch.float64)).numpy()
    place, velocity = [0.1, 0.2, 1.0], [0.4, -0.5, 0.6]
    action = {"thrust_rates": [0.3, 0, 0, 0], "thrust_attitude": [0.3, *attitude], "motors": [0.5] * 4}[interface]
    state = [*place, *attitude, *velocity, *([0.0] * 3 if interface != "thrust_attitude" else [])]
    after = step(full, state, action)
    short = step(measured, [*place, *velocity], action[: measured.layouts.action.size], [0.01, 0, 0, *attitude])
    forced = np.array([0.5 * 0.02**2, 0, 0, 0.02, 0, 0]) * 0.01 / 0.027
    np.testing.assert_allclose(short, np.array([*after[:3], *after[7:10]]) + forced, atol=1e-9)


def test_a_measured_attitude_turns_within_a_row() -> None:
    """Held as it was at the row's start, it pushes a robot that sways aside, as a drag would."""
    robot, rows = CRAZYFLIE, 150
    sway = np.column_stack([np.full(rows, MASS * GRAVITY), 4.0 * np.sin(0.3 * np.arange(rows)), *np.zeros((2, rows))])
    log = run_episode(MujocoPlant(robot), Replayed(sway), start=state13(z=2.0), steps=rows)
    base = quadrotor(MASS, attitude="measured")
    known = prepared(base, Dataset([log]))[1][0]
    held, turning = (
        step(base, known.state[:-1], known.action[:-1], inputs[:-1])[:, 4] - known.state[1:, 4]
        for inputs in (known.inputs, known.step_inputs)
    )
    assert np.linalg.norm(turning) < 0.1 * np.linalg.norm(held)


def test_attitude_follows_its_command_the_short_way() -> None:
    equations = quadrotor(1.0, interface="thrust_attitude", attitude_time_constant=0.1)
    wanted = rotation.from_euler(*torch.tensor([0.2, 0.1, 0.0], dtype=torch.float64)).numpy()
    start = np.array([0, 0, 1, 1, 0, 0, 0, 0, 0, 0], dtype=float)
    for side in (1.0, -1.0):
        actions = np.tile([GRAVITY, *(side * wanted)], (5, 1))
        end = predicted(equations, start, actions)[-1, 3:7]
        left = rotation.logarithm(torch.as_tensor(wanted)) - rotation.logarithm(torch.as_tensor(end))
        share = left / rotation.logarithm(torch.as_tensor(wanted))
        np.testing.assert_allclose(share[:2], np.exp(-1.0), rtol=0.01)


def test_the_bicycle_stays_on_its_circle() -> None:
    steer, speed, dt = 0.3, 1.5, 0.05
    equations = car(0.2955, dt=dt)
    radius = 0.2955 / np.tan(steer)
    states = predicted(equations, np.array([0, 0, 0, 1.0, speed, 0, speed / radius]), np.tile([steer, speed], (200, 1)))
    np.testing.assert_allclose(np.hypot(states[:, 0], states[:, 1] - radius), radius, rtol=1e-6)
    np.testing.assert_allclose(states[-1, 2], np.sin(200 * dt * speed / radius), atol=1e-6)
    np.testing.assert_allclose(np.hypot(states[:, 4], states[:, 5]), speed, rtol=1e-9)


def test_the_speed_loop_of_the_bicycle_is_first_order() -> None:
    equations = car(0.3, time_constant=0.2, mass=4.0)
    start = np.array([0, 0, 0, 1.0, 0, 0, 0])
    states = predicted(equations, start, np.tile([0.0, 1.0], (20, 1)))
    time = 0.05 * np.arange(21)
    np.testing.assert_allclose(states[:, 4], 1 - np.exp(-time / 0.2), atol=1e-9)
    np.testing.assert_allclose(states[:, 0], time - 0.2 * (1 - np.exp(-time / 0.2)), atol=1e-9)
    pushed = predicted(equations, start, np.zeros((100, 2)), np.tile([4.0, 0.0, 0.0], (100, 1)))
    assert pushed[-1, 4] == pytest.approx(4.0 / 4.0 * 0.2)


def test_a_commanded_acceleration_is_integrated_with_what_pushes() -> None:
    equations = car(0.3, command="acceleration", mass=4.0)
    actions, pushes = np.tile([0.0, 0.8], (40, 1)), np.tile([2.0, 0.0, 0.0], (40, 1))
    states = predicted(equations, np.array([0, 0, 0, 1.0, 0.5, 0, 0]), actions, pushes)
    time, gained = 0.05 * np.arange(41), 0.8 + 2.0 / 4.0
    np.testing.assert_allclose(states[:, 4], 0.5 + gained * time, atol=1e-9)
    np.testing.assert_allclose(states[:, 0], 0.5 * time + gained * time**2 / 2, atol=1e-9)
    with pytest.raises(ModelError, match="acceleration without time_constant"):
        car(0.3, command="acceleration", time_constant=0.1)


def test_the_thrust_of_a_log_is_found_from_its_first_seconds() -> None:
    rng = np.random.default_rng(0)
    layouts = Layouts(
        Layout.of(("x", "y", "z", "vx", "vy", "vz")),
        Layout.of(("motor1", "motor2", "motor3", "motor4")),
        Layout.of(("qw", "qx", "qy", "qz")),
    )
    true = 2.84
    time = 0.02 * np.arange(200)
    motors = 3.45 / 4 * (1 + 0.05 * np.sin(3 * time))[:, None] * np.ones(4)
    attitude = rotation.from_euler(
        torch.as_tensor(0.2 * np.sin(2 * time)), torch.as_tensor(0.2 * np.cos(time)), torch.zeros(200).double()
    )
    push = true * motors.sum(1)[:, None] * rotation.rotate(attitude, torch.tensor([0.0, 0, 1.0]).double()).numpy()
    velocity = np.cumsum(np.vstack([np.zeros(3), (push - [0, 0, GRAVITY])[:-1] * 0.02]), axis=0)
    state = np.hstack([np.zeros((200, 3)), velocity + 0.01 * rng.normal(size=velocity.shape)])
    log = Trajectory(time, state, motors, attitude.numpy(), layouts)
    assert fit_thrust_per_unit(log) == pytest.approx(true, rel=2e-3)
    still = Trajectory(time, state, 0 * motors, attitude.numpy(), layouts)
    with pytest.raises(ModelError, match="no thrust in the first"):
        fit_thrust_per_unit(still)
    with pytest.raises(ModelError, match="ten rows"):
        fit_thrust_per_unit(log, seconds=0.1)


def test_speeds_of_a_flight_give_the_thrust_per_squared_speed() -> None:
    """MuJoCo's forces at four sites, logged as the speeds of rotors that push with k ω²."""
    per_squared_speed = 2.2e-8  # N s²/rad²: about the Crazyflie's
    (log,) = motor_flights(names=["circle"], seconds=4.0)
    speeds = np.sqrt(THRUST * log.action / per_squared_speed)
    turning = replace(log, action=speeds)
    found = fit_thrust_per_unit(turning, unit="rad/s") * MASS
    assert found == pytest.approx(per_squared_speed, rel=0.02)
    motors = Motors(found, "rad/s", torque_per_thrust=TORQUE_PER_THRUST, arm=ARM)
    model = quadrotor(MASS, INERTIA, interface="motors", motors=motors, dt=log.dt)
    assert compare(model, turning, horizons=(0.2,)).at(0.2).errors["velocity"].skill > 0.5


def test_a_guess_is_written_down_and_a_given_number_is_not() -> None:
    assert len(quadrotor(1.2, interface="motors").notes) == 2
    assert quadrotor(1.2, (0.01, 0.01, 0.02), interface="motors", motors=MOTORS).notes == ()
    loop = (20.0, 20.0, 8.0)
    assert quadrotor(1.0, (0.01, 0.01, 0.02), rate_gains=loop).notes == ()
    assert quadrotor(None, (0.01, 0.01, 0.02), rate_gains=loop).notes == (PER_KILOGRAM,)
    (guessed,) = quadrotor(1.0, (0.01, 0.01, 0.02)).notes
    assert "50 50 20 1/s" in guessed
    (measured,) = quadrotor(0.03, (1.43e-5, 1.43e-5, 2.89e-5), rate_gains=loop).notes
    assert "above the sum of the others" in measured
    hovering = step(quadrotor(1.2, interface="motors"), state13(z=1.0), [0.5] * 4)
    np.testing.assert_allclose(hovering, state13(z=1.0), atol=1e-12)
    scaled = quadrotor(0.027)
    given = quadrotor(0.027, INERTIA)
    state = quadrotor_start(0)
    np.testing.assert_allclose(step(scaled, state, [0.3, 1, 1, 1]), step(given, state, [0.3, 1, 1, 1]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": 0.0}, "mass"),
        ({"mass": 1.0, "dt": -0.1}, "dt"),
        ({"mass": 1.0, "interface": "rates"}, "thrust_rates"),
        ({"mass": 1.0, "attitude": "guessed"}, "measured"),
        ({"mass": 1.0, "inertia": (1.0, 1.0)}, "three positive"),
        ({"mass": 1.0, "inertia": (1.0, 1.0, 3.0)}, "above the sum"),
        ({"interface": "thrust_attitude", "attitude_time_constant": -0.1}, "τ ≥ 0"),
        ({"rate_gains": (50.0, 0.0, 20.0)}, "gains > 0"),
    ],
)
def test_numbers_that_no_quadrotor_has_are_refused(arguments: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        quadrotor(**arguments)


def test_numbers_that_no_car_or_motor_has_are_refused() -> None:
    with pytest.raises(ModelError, match="wheelbase"):
        car(0.0)
    with pytest.raises(ModelError, match="must not be negative"):
        Motors(thrust=-0.1)
    with pytest.raises(ModelError, match="arm in m positive"):
        Motors(thrust=0.1, arm=0.0)
    with pytest.raises(ModelError, match="1 or -1"):
        Motors(thrust=0.1, spin=(1, 0, 1, -1))


@pytest.mark.parametrize(
    ("equations", "said"),
    [
        (lambda: car(26.0), "wheelbase 26 m: more than 4 m.*0.26 m if it is in cm"),
        (lambda: car(0.2955, mass=3500.0), "mass 3500 kg: more than 25.8 kg.*3.5 kg if it is in g"),
        (lambda: quadrotor(27.0), "mass 27 kg: more than 25 kg.*0.027 kg if it is in g"),
        (lambda: quadrotor(0.027, (166.0, 166.0, 290.0)), "jx 166 kg m².*1.66e-05 kg m² if it is in g cm²"),
        (
            lambda: quadrotor(0.027, interface="motors", motors=Motors(0.1, arm=4.6)),
            "arm 4.6 m.*0.046 m if it is in cm",
        ),
    ],
)
def test_numbers_that_no_such_robot_has_are_told_with_what_is_meant(
    equations: Callable[[], Equations], said: str
) -> None:
    assert any(re.search(said, note) for note in equations().notes)


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_the_robots_that_come_along_are_likely(robot: Robot) -> None:
    assert not any("is the unit right?" in note for note in robot.nominal().notes)


def test_equations_are_told_in_short_by_their_columns_and_numbers() -> None:
    assert interface_lines(car(0.3, dt=0.05)) == [
        "every 0.05 s",
        "predicts x, y, sin_yaw, cos_yaw, vx, vy, wz",
        "from steer, speed",
        "takes, where a log has them, fx, fy, tz",
        "numbers (SI): mass 3.5, wheelbase 0.3, centre 0.15",
    ]
