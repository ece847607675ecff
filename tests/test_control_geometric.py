"""Geometric controllers on the MuJoCo plants: from bad starts, on moving references, in both directions."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sym2real.control import GeometricQuadrotor, PurePursuit, RandomCommands
from sym2real.control.at_steps import AHEAD, AtSteps
from sym2real.control.geometric_quadrotor import Gains, reference_points
from sym2real.plants import MujocoPlant, run_episode
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.rotation import from_euler, to_matrix, yaw
from sym2real.tasks import Task, make_task
from sym2real.trajectory import Trajectory


def fly(task: Task, start: np.ndarray, steps: int = 300, yaw_rate: float = 0.0) -> Trajectory:
    robot = CRAZYFLIE
    controller = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, task.reference, yaw_rate)
    return run_episode(MujocoPlant(robot), controller, task, start=start, steps=steps)


def drive(task: Task, start: np.ndarray, steps: int = 300) -> Trajectory:
    robot = MUSHR
    wheelbase = robot.numbers["wheelbase"]
    controller = PurePursuit(wheelbase, robot.low, robot.high, robot.dt, task.reference)
    return run_episode(MujocoPlant(robot), controller, task, start=start, steps=steps)


def error(trajectory: Trajectory, axes: str) -> np.ndarray:
    return np.linalg.norm([trajectory.column(axis) - trajectory.column(f"ref_{axis}") for axis in axes], axis=0)


def tilted(roll: float, pitch: float, heading: float, height: float) -> np.ndarray:
    state = CRAZYFLIE.start.copy()
    state[2] = height
    state[3:7] = from_euler(*(torch.tensor(angle, dtype=torch.float64) for angle in (roll, pitch, heading)))
    return state


@pytest.mark.parametrize(("roll", "pitch", "heading"), [(0.6, 0.0, 0.0), (1.2, 0.5, 0.4), (2.6, 0.0, -2.0)])
def test_quadrotor_recovers_from_a_tilted_start(roll: float, pitch: float, heading: float) -> None:
    trajectory = fly(make_task("hover", CRAZYFLIE, goal=(0, 0, 3)), tilted(roll, pitch, heading, 3.0))
    assert len(trajectory) == 300
    assert error(trajectory, "xyz")[-25:].max() < 1e-3
    final = torch.from_numpy(trajectory.state[-1, 3:7])
    assert float(to_matrix(final)[2, 2]) > 1 - 1e-6
    assert abs(float(yaw(final))) < 1e-3


def expected_error(task: Task) -> float:
    """Amplitude of the tracking error in m that the rate loop's lag leaves, linearised, at the reference's frequency.

    The rate that is fed forward comes 1/gain + half a control period late; attitude feedback divides that by
    |K_R + iω|, position feedback by |K_p - ω² + iωK_v|.
    """
    points = reference_points(task.reference, torch.arange(3.0, 6.0, CRAZYFLIE.dt, dtype=torch.float64))
    speed = max(np.linalg.norm(point.velocity) for point in points)
    acceleration = max(np.linalg.norm(point.acceleration) for point in points)
    frequency, gains = acceleration / speed, Gains()
    late = 1 / CRAZYFLIE.numbers["kx"] + CRAZYFLIE.dt / 2
    tilted = late * acceleration * frequency**2 / abs(gains.attitude + 1j * frequency)
    return float(tilted / abs(gains.position - frequency**2 + 1j * frequency * gains.velocity))


@pytest.mark.parametrize("name", ["circle", "lemniscate"])
def test_quadrotor_follows_a_moving_reference(name: str) -> None:
    """As closely as the lag of its rate loop lets it; twice that, for the reference's harmonics."""
    task = make_task(name, CRAZYFLIE)
    trajectory = fly(task, task.start(np.random.default_rng(0)))
    assert error(trajectory, "xyz")[150:].max() < 2 * expected_error(task)


def test_reference_is_differentiated_twice() -> None:
    """On a circle with ω = 2 rad/s: a = -ω² p, da/dt = -ω² v."""
    reference = make_task("circle", CRAZYFLIE, radius=0.5, speed=1.0).reference
    (point,) = reference_points(reference, torch.tensor([0.7], dtype=torch.float64))
    np.testing.assert_allclose(point.acceleration, -4.0 * (point.position - [0, 0, 1]), rtol=1e-3)
    np.testing.assert_allclose(point.jerk, -4.0 * point.velocity, rtol=1e-3)


def test_quadrotor_turns_while_it_hovers() -> None:
    trajectory = fly(make_task("hover", CRAZYFLIE), CRAZYFLIE.start, yaw_rate=0.5)
    assert error(trajectory, "xyz").max() < 1e-3
    np.testing.assert_allclose(trajectory.column("wz")[50:], 0.5, atol=1e-3)


def test_quadrotor_commands_stay_within_limits_far_from_the_goal() -> None:
    start = tilted(1.5, -1.0, 2.0, 2.0)
    start[7:10] = [3.0, -2.0, -4.0]
    task = make_task("hover", CRAZYFLIE, goal=(20, -30, 10))
    controller = GeometricQuadrotor(CRAZYFLIE.mass, CRAZYFLIE.low, CRAZYFLIE.high, CRAZYFLIE.dt, task.reference)
    action = controller.act(start, 0)
    assert (action >= CRAZYFLIE.low).all() and (action <= CRAZYFLIE.high).all()


def test_quadrotor_commutes_with_a_turn_of_the_world() -> None:
    """Rotate state and reference by the same yaw: thrust and body rates stay."""
    turn = from_euler(torch.tensor(0.0), torch.tensor(0.0), torch.tensor(1.1)).to(torch.float64)
    rotate = to_matrix(turn).numpy()
    task = make_task("circle", CRAZYFLIE)

    def turned(time: torch.Tensor) -> torch.Tensor:
        reference = task.reference(time).clone()
        for columns in (slice(0, 3), slice(7, 10)):
            reference[..., columns] = reference[..., columns] @ torch.from_numpy(rotate).T
        reference[..., 3:7] = turn / turn.norm()
        return reference

    state = tilted(0.3, -0.2, 0.4, 1.2)
    state[7:10] = [0.3, -0.1, 0.2]
    there = state.copy()
    there[:3], there[7:10] = rotate @ state[:3], rotate @ state[7:10]
    heading = from_euler(*(torch.tensor(angle, dtype=torch.float64) for angle in (0.3, -0.2, 1.5)))
    there[3:7] = heading
    make = lambda reference: GeometricQuadrotor(0.027, CRAZYFLIE.low, CRAZYFLIE.high, 0.02, reference)  # noqa: E731
    np.testing.assert_allclose(make(turned).act(there, 9), make(task.reference).act(state, 9), atol=1e-6)


@pytest.mark.parametrize("name", ["circle", "reverse_circle"])
@pytest.mark.parametrize("clockwise", [False, True])
def test_car_follows_a_circle_both_ways_forward_and_in_reverse(name: str, clockwise: bool) -> None:
    task = make_task(name, MUSHR, clockwise=clockwise)
    trajectory = drive(task, task.start(np.random.default_rng(0)), steps=240)
    assert error(trajectory, "xy")[60:].max() < 0.03
    velocity = trajectory.column("vx") * trajectory.column("cos_yaw") + trajectory.column("vy") * trajectory.column(
        "sin_yaw"
    )
    assert np.sign(velocity[60:]).tolist() == [-1.0 if name == "reverse_circle" else 1.0] * 180
    turning = (-1.0 if clockwise else 1.0) * trajectory.column("wz")[60:]
    assert (turning > 0.4).all()


@pytest.mark.parametrize("region", ["seen", "unseen"])
@pytest.mark.parametrize("seed", range(3))
def test_car_parks_from_both_sides(region: str, seed: int) -> None:
    task = make_task("park", MUSHR, start_region=region)
    trajectory = drive(task, task.start(np.random.default_rng(seed)), steps=240)
    assert error(trajectory, "xy")[-20:].max() < 0.05
    assert np.abs(trajectory.action[-20:, 1]).max() < 0.05


@pytest.mark.parametrize("robot", [CRAZYFLIE, MUSHR], ids=lambda robot: robot.name)
def test_random_commands_fill_their_range_and_are_held(robot: Robot) -> None:
    held = round(0.2 / robot.dt)
    commands = RandomCommands(robot, hold=0.2, seed=3)
    actions = np.array([commands.act(robot.start, step) for step in range(300 * held)])
    blocks = actions.reshape(300, held, -1)
    np.testing.assert_array_equal(blocks, np.repeat(blocks[:, :1], held, axis=1))
    span = robot.limits.random_high - robot.limits.random_low
    place = (blocks[:, 0] - robot.limits.random_low) / span
    assert place.min() >= 0 and place.max() <= 1
    np.testing.assert_allclose(place.mean(0), 0.5, atol=0.06)
    np.testing.assert_allclose(place.std(0), 12**-0.5, atol=0.03)
    again = RandomCommands(robot, hold=0.2, seed=3)
    np.testing.assert_array_equal(again.act(robot.start, 77), actions[77])
    assert not np.array_equal(RandomCommands(robot, seed=4).act(robot.start, 77), actions[77])


def test_whatever_steps_are_asked_for_a_reference_is_that_of_their_times() -> None:
    blocks: list[int] = []

    def wanted(times: torch.Tensor) -> list[float]:
        blocks.append(len(times))
        return times.tolist()

    at_steps = AtSteps(wanted, dt=0.02)
    steps = [0, 1, AHEAD - 1, AHEAD, 2 * AHEAD - 1, 7, 3 * AHEAD, 3 * AHEAD + 5]
    np.testing.assert_allclose([at_steps[step] for step in steps], 0.02 * np.array(steps), rtol=1e-14)
    assert blocks == [AHEAD] * 4  # from 0, from AHEAD, back at 7, from 3 AHEAD
