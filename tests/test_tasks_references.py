"""References are trajectories: velocities are derivatives, headings are tangents, episodes start where they say."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from paper_robots import PAPER_ROBOTS

from sym2real.errors import ShapeError, UnknownNameError
from sym2real.robots import ROBOTS
from sym2real.robots.from_mjcf import from_mjcf
from sym2real.tasks import TASKS, make_task, unseen_goal
from sym2real.tasks.track import TRACKS, pieces_of

FLIGHTS = [("hover", {}), ("hover", {"goal": (0.3, -0.2, 1.4)}), ("circle", {}), ("circle", {"clockwise": True}),
           ("lemniscate", {}), ("track", {}), ("track", {"shape": "hook"})]  # fmt: skip
DRIVES = [("circle", {}), ("circle", {"clockwise": True}), ("lemniscate", {}), ("track", {}), ("park", {}),
          ("track", {"shape": "hook", "speed": 2.4}), ("reverse_circle", {}), ("reverse_circle", {"clockwise": True}),
          ("park", {"goal": (0.0, 1.0), "yaw": 2.0})]  # fmt: skip
CASES = [("crazyflie", *case) for case in FLIGHTS] + [("mushr", *case) for case in DRIVES]

TIMES = torch.linspace(0.013, 24.013, 601, dtype=torch.float64)
HALF_STEP = 1e-5


@pytest.mark.parametrize(("robot_name", "name", "options"), CASES)
def test_velocity_is_the_derivative_of_position(robot_name: str, name: str, options: dict) -> None:
    robot = ROBOTS[robot_name]
    layout, reference = robot.layouts.state, make_task(name, robot, **options).reference
    before, here, after = (reference(TIMES + step) for step in (-HALF_STEP, 0.0, HALF_STEP))
    moved = (after - before)[:, layout.slice("position")] / (2 * HALF_STEP)
    torch.testing.assert_close(moved, here[:, layout.slice("velocity")], atol=1e-6, rtol=1e-6)


@pytest.mark.parametrize(("robot_name", "name", "options"), CASES)
def test_rate_is_the_derivative_of_the_rotation(robot_name: str, name: str, options: dict) -> None:
    robot = ROBOTS[robot_name]
    layout, reference = robot.layouts.state, make_task(name, robot, **options).reference
    before, here, after = (reference(TIMES + step) for step in (-HALF_STEP, 0.0, HALF_STEP))
    tangent = layout.difference(after, before) / (2 * HALF_STEP)
    position, turned = len(layout.field("position").columns), 3 if layout.has_field("attitude") else 1
    torch.testing.assert_close(
        tangent[:, position : position + turned], here[:, layout.slice("rate")], atol=1e-5, rtol=1e-5
    )


@pytest.mark.parametrize(("name", "options"), DRIVES)
def test_car_points_along_its_path_or_against_it(name: str, options: dict) -> None:
    reference = make_task(name, ROBOTS["mushr"], **options).reference(TIMES)
    sine, cosine, vx, vy = reference[:, 2:6].unbind(-1)
    torch.testing.assert_close(sine**2 + cosine**2, torch.ones_like(sine))
    forward, sideways = cosine * vx + sine * vy, cosine * vy - sine * vx
    torch.testing.assert_close(sideways, torch.zeros_like(sideways), atol=1e-12, rtol=0)
    sign = {"park": 0.0, "reverse_circle": -1.0}.get(name, 1.0)
    torch.testing.assert_close(forward, sign * torch.hypot(vx, vy))


@pytest.mark.parametrize(("name", "options"), FLIGHTS)
def test_quadrotor_reference_is_level_with_yaw_zero(name: str, options: dict) -> None:
    reference = make_task(name, ROBOTS["crazyflie"], **options).reference(TIMES)
    upright = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=torch.float64)
    torch.testing.assert_close(reference[:, 3:7], upright.expand(len(TIMES), 4))


def test_sizes_and_speeds_are_those_of_the_facts() -> None:
    reference = make_task("circle", ROBOTS["mushr"]).reference(TIMES)
    torch.testing.assert_close(torch.hypot(reference[:, 0], reference[:, 1]), torch.full_like(TIMES, 1.5))
    torch.testing.assert_close(torch.hypot(reference[:, 4], reference[:, 5]), torch.full_like(TIMES, 0.825))
    parked = make_task("park", ROBOTS["mushr"]).reference(TIMES)
    assert (parked == torch.tensor([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], dtype=torch.float64)).all()


@pytest.mark.parametrize(("name", "options"), DRIVES)
def test_car_can_steer_what_is_asked_for(name: str, options: dict) -> None:
    robot = ROBOTS["mushr"]
    reference = make_task(name, robot, **options).reference(TIMES)
    speed, rate = torch.hypot(reference[:, 4], reference[:, 5]), reference[:, 6].abs()
    tightest = np.tan(robot.high[0]) / robot.numbers["wheelbase"]
    assert bool((rate <= 0.95 * tightest * speed + 1e-9).all())
    assert float(speed.max()) <= robot.high[1]


@pytest.mark.parametrize("shape", TRACKS)
def test_track_closes_turns_once_and_keeps_its_radius(shape: str) -> None:
    polygon = TRACKS[shape]
    pieces = pieces_of(polygon, 1.0)
    assert (pieces[:, 4] > 0).all()
    assert (pieces[:, 3] * pieces[:, 4]).sum() == pytest.approx(2 * np.pi)
    curved = np.abs(pieces[pieces[:, 3] != 0, 3])
    np.testing.assert_allclose(1 / curved, polygon.radius)
    lap = pieces[:, 4].sum() / 0.6
    reference = make_task("track", ROBOTS["mushr"], shape=shape, speed=0.6).reference
    times = torch.tensor([0.0, lap - 1e-9, lap + 1e-9], dtype=torch.float64)
    start, end, again = reference(times)
    torch.testing.assert_close(end[:-1], start[:-1], atol=1e-6, rtol=0)  # the yaw rate jumps where an arc ends
    torch.testing.assert_close(again, start, atol=1e-6, rtol=0)


@pytest.mark.parametrize(("robot_name", "name", "options"), CASES)
def test_references_take_any_batch_and_keep_the_dtype(robot_name: str, name: str, options: dict) -> None:
    robot = ROBOTS[robot_name]
    task = make_task(name, robot, **options)
    flat = task.reference(TIMES[:12])
    folded = task.reference(TIMES[:12].reshape(3, 4))
    assert folded.shape == (3, 4, robot.layouts.state.size)
    torch.testing.assert_close(folded.reshape(12, -1), flat)
    single = task.reference(TIMES[:12].float())
    assert single.dtype == torch.float32
    torch.testing.assert_close(single.double(), flat, atol=1e-4, rtol=1e-4)
    assert task.reference(torch.tensor(0.0)).shape == (robot.layouts.state.size,)


@pytest.mark.parametrize(("robot_name", "name", "options"), CASES)
def test_episodes_start_at_rest_on_the_manifold_and_by_seed(robot_name: str, name: str, options: dict) -> None:
    robot = ROBOTS[robot_name]
    layout, task = robot.layouts.state, make_task(name, robot, **options)
    states = np.array([task.start(np.random.default_rng(seed)) for seed in range(50)])
    np.testing.assert_array_equal(states[7], task.start(np.random.default_rng(7)))
    tensor = torch.from_numpy(states)
    torch.testing.assert_close(layout.normalise(tensor), tensor)
    assert (states[:, layout.slice("velocity")] == 0).all()
    assert (states[:, layout.slice("rate")] == 0).all()
    if layout.has_field("attitude"):
        np.testing.assert_array_equal(states[:, 2], 1.0)
    elif name != "park":
        first = task.reference(torch.tensor(0.0, dtype=torch.float64)).numpy()
        assert np.abs(states[:, :2] - first[:2]).max() <= 0.1
        assert (states[:, 2:4] @ first[2:4] >= np.cos(np.deg2rad(10.0)) - 1e-12).all()


def test_parking_starts_on_the_side_that_is_asked_for() -> None:
    robot = ROBOTS["mushr"]
    for region, (low, high) in {"seen": (-1.0, -0.5), "unseen": (2.5, 3.0)}.items():
        task = make_task("park", robot, start_region=region)
        states = np.array([task.start(np.random.default_rng(seed)) for seed in range(200)])
        yaw = np.arctan2(states[:, 2], states[:, 3])
        assert low <= states[:, 0].min() < states[:, 0].max() <= high
        assert -1.0 <= states[:, 1].min() < -0.8 < 0.8 < states[:, 1].max() <= 1.0
        assert np.deg2rad(40) < np.abs(yaw).max() <= np.deg2rad(45)


def test_unseen_goals_fill_the_volume_of_the_paper() -> None:
    rng = np.random.default_rng(0)
    goals = np.array([unseen_goal(rng) for _ in range(500)])
    np.testing.assert_allclose(goals.max(0) - goals.min(0), [0.6, 0.6, 1.0], rtol=0.03)
    np.testing.assert_allclose((goals.max(0) + goals.min(0)) / 2, [0.0, 0.0, 1.0], atol=0.02)


def test_wrong_names_and_wrong_robots_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'hover'"):
        make_task("hovver", ROBOTS["crazyflie"])
    with pytest.raises(ShapeError, match="heading"):
        make_task("park", ROBOTS["crazyflie"])
    with pytest.raises(ShapeError, match="attitude"):
        make_task("hover", ROBOTS["mushr"])
    with pytest.raises(UnknownNameError, match="unseen"):
        make_task("park", ROBOTS["mushr"], start_region="unsen")
    assert set(TASKS) == {"hover", "circle", "lemniscate", "track", "park", "reverse_circle", "regulate"}


GIMBAL = """
<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom type="box" size=".1 .1 .02" mass=".5"/><site name="up"/>
<body pos="0 0 -.05"><joint name="gimbal" axis="0 1 0"/><geom type="box" size=".02 .02 .02" mass=".05"/></body></body>
</worldbody><actuator><motor name="lift" site="up" gear="0 0 1 0 0 0" ctrlrange="0 9"/></actuator></mujoco>
"""


@pytest.mark.parametrize("name", ["hover", "circle", "lemniscate", "track"])
def test_a_drone_with_a_joint_is_given_no_path_that_says_nothing_of_it(name: str) -> None:
    robot = from_mjcf(GIMBAL, name="gimbal_drone")
    with pytest.raises(ShapeError, match=r"gimbal_drone has x y z qw qx qy qz gimbal .* 'regulate' is for any robot"):
        make_task(name, robot)
    assert make_task("regulate", robot).reference(torch.zeros(2)).shape == (2, len(robot.layouts.state))


@pytest.mark.parametrize("robot_name", PAPER_ROBOTS)
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("circle", {"radius": 0}),
        ("circle", {"speed": 0}),
        ("circle", {"radius": float("nan")}),
        ("lemniscate", {"period": 0}),
        ("lemniscate", {"half_width": -1.0}),
        ("track", {"scale": 0}),
        ("track", {"speed": float("inf")}),
    ],
)
def test_paths_that_nobody_can_follow_are_refused(robot_name: str, name: str, options: dict) -> None:
    with pytest.raises(ShapeError, match=f"task '{name}': expected {next(iter(options))} > 0"):
        make_task(name, ROBOTS[robot_name], **options)


@pytest.mark.parametrize(
    "options", [{"duration": 0}, {"duration": np.nan}, {"spread": np.inf}, {"goal": {"z": np.nan}}]
)
def test_a_goal_that_is_no_number_is_refused(options: dict) -> None:
    with pytest.raises(ShapeError, match="task 'regulate': expected"):
        make_task("regulate", ROBOTS["crazyflie"], **options)


def test_a_goal_beyond_an_end_stop_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"expected shoulder from .* its range, found 9"):
        make_task("regulate", ROBOTS["arm"], goal={"shoulder": 9.0})


def test_places_are_all_of_their_numbers() -> None:
    with pytest.raises(ShapeError, match="3 finite numbers"):
        make_task("hover", ROBOTS["crazyflie"], goal=(1.0, 2.0))
    with pytest.raises(ShapeError, match="2 finite numbers"):
        make_task("park", ROBOTS["mushr"], goal=(1.0,))
    with pytest.raises(ShapeError, match="2 finite numbers"):
        make_task("park", ROBOTS["mushr"], goal=(1.0, float("nan")))
