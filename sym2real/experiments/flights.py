"""Flights and drives that base models are trained and tested on.

A quadrotor hovers and flies circles and figures of eight of radius 0.3–0.6 m at 1–2 rad/s, from tilted starts with
coloured noise on the commands, and levelled random rates from 2 m.
A car drives circles, to goals, and on random commands up to 2 m/s.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.control import Disturbed, GeometricQuadrotor, PurePursuit
from sym2real.dataset import Dataset
from sym2real.experiments.excitation import ColouredNoise, GoalAfterGoal, RandomDriving, RandomRates, unlimited
from sym2real.plants import MujocoPlant, random_wrench, run_episode
from sym2real.protocols import Change, Controller
from sym2real.robots import CRAZYFLIE, MUSHR, Robot
from sym2real.rotation import exponential
from sym2real.tasks import make_task
from sym2real.trajectory import Array, Trajectory

Setting = tuple[Controller, Array]
Draw = Callable[[Robot, np.random.Generator], Setting]

NOISE = np.array([0.03, 1.0, 1.0, 1.0])  # N, rad/s
NOISE_CORRELATION = 0.08  # s
TURNING = 0.5  # rad/s, of the heading in tracking flights
SPEED_LIMIT = 2.0  # m/s, of drives


@dataclass(frozen=True)
class Style:
    """How hard tracking flights are.

    Args:
        noise: factor on :data:`NOISE`.
        tilt: of the start at most, rad.
        height: in m.
        radius: least and largest, m.
        rate: least and largest angular rate along the path, rad/s.
    """

    noise: float
    tilt: float
    height: float
    radius: tuple[float, float]
    rate: tuple[float, float]


CALM = Style(noise=1.0, tilt=0.2, height=1.0, radius=(0.3, 0.6), rate=(1.0, 2.0))


def quadrotor_flights(
    count: int,
    seed: int,
    *,
    steps: int = 400,
    changes: Sequence[Change] = (),
    forced: bool = False,
) -> Dataset:
    """Flights of a quadrotor in MuJoCo, one kind after the other; a flight ends early when it hits the ground.

    Args:
        count: number of flights.
        seed: equal seeds give equal flights.
        steps: rows of a flight.
        changes: differences of the plant.
        forced: under a random wrench.
    """
    kinds = (circle, eight, _hover, _levelled_rates)
    return runs(CRAZYFLIE, MujocoPlant(CRAZYFLIE, changes), kinds, count, seed, steps=steps, forced=forced)


def car_drives(
    count: int,
    seed: int,
    *,
    steps: int = 400,
    changes: Sequence[Change] = (),
    forced: bool = False,
    robot: Robot = MUSHR,
) -> Dataset:
    """Drives of a car in MuJoCo, one kind after the other; arguments as of :func:`quadrotor_flights`, and the car."""
    kinds = (_round, _goals, _random_driving)
    return runs(robot, MujocoPlant(unlimited(robot), changes), kinds, count, seed, steps=steps, forced=forced)


def runs(
    robot: Robot, plant: MujocoPlant, kinds: Sequence[Draw], count: int, seed: int, *, steps: int, forced: bool = False
) -> Dataset:
    """Runs of the kinds, one after the other, of a robot within its limits on a plant that may have none."""
    made: list[Trajectory] = []
    for index in range(count):
        draw, rng = kinds[index % len(kinds)], np.random.default_rng([seed, index])
        controller, start = draw(robot, rng)
        wrench = random_wrench(plant.robot, steps, rng) if forced else None
        name = f"{draw.__name__.strip('_')}_{index}"
        made.append(run_episode(plant, controller, start=start, steps=steps, wrench=wrench, name=name))
    return Dataset(made)


def tilted(robot: Robot, rng: np.random.Generator, most: float, position: Array) -> Array:
    """A start at rest, tilted by up to ``most`` rad about a horizontal axis ``# (13,)``."""
    direction, angle = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, most)
    axis = torch.tensor([angle * np.cos(direction), angle * np.sin(direction), 0.0], dtype=torch.float64)
    start = robot.start.copy()
    start[:3], start[3:7] = position, exponential(axis).numpy()
    return start


def _track(robot: Robot, rng: np.random.Generator, task: str, style: Style, **options: float | bool) -> Setting:
    """Geometric tracking of a task, lifted to the style's height, with noisy commands."""
    path = make_task(task, robot, **options).reference
    lift = torch.zeros(13, dtype=torch.float64)
    lift[2] = style.height - 1.0

    def reference(time: Tensor) -> Tensor:
        return path(time) + lift

    # A heading that never turns leaves every term with qz to chance.
    turning = rng.uniform(-TURNING, TURNING)
    tracking = GeometricQuadrotor(robot.mass, robot.low, robot.high, robot.dt, reference, yaw_rate=turning)
    coloured = ColouredNoise(style.noise * NOISE, NOISE_CORRELATION, robot.dt, rng)
    position = reference(torch.zeros((), dtype=torch.float64)).numpy()[:3]
    return Disturbed(tracking, coloured.next, robot.low, robot.high), tilted(robot, rng, style.tilt, position)


def _hover(robot: Robot, rng: np.random.Generator) -> Setting:
    return _track(robot, rng, "hover", CALM)


def circle(robot: Robot, rng: np.random.Generator, style: Style = CALM) -> Setting:
    """Circles, either way round."""
    radius, rate = rng.uniform(*style.radius), rng.uniform(*style.rate)
    clockwise = bool(rng.integers(2))
    return _track(robot, rng, "circle", style, radius=radius, speed=radius * rate, clockwise=clockwise)


def eight(robot: Robot, rng: np.random.Generator, style: Style = CALM) -> Setting:
    """Figures of eight."""
    radius, rate = rng.uniform(*style.radius), rng.uniform(*style.rate)
    return _track(robot, rng, "lemniscate", style, half_width=radius, period=2.0 * np.pi / rate)


def _levelled_rates(robot: Robot, rng: np.random.Generator) -> Setting:
    controller = RandomRates(robot, rng, levelling=8.0, climbing=0.7)
    return controller, tilted(robot, rng, CALM.tilt, np.array([0.0, 0.0, 2.0]))


def around(
    robot: Robot, rng: np.random.Generator, task: str, *, radius: float, speed: float, fastest: float
) -> Setting:
    """Pure pursuit of a circle, either way round."""
    path = make_task(task, robot, radius=radius, speed=speed, clockwise=bool(rng.integers(2)))
    low, high = np.array([robot.low[0], -fastest]), np.array([robot.high[0], fastest])
    controller = PurePursuit(robot.numbers["wheelbase"], low, high, robot.dt, path.reference)
    return controller, path.start(rng)


def _round(robot: Robot, rng: np.random.Generator) -> Setting:
    return around(robot, rng, "circle", radius=rng.uniform(1.0, 2.0), speed=rng.uniform(0.8, 1.6), fastest=SPEED_LIMIT)


def _parked(rng: np.random.Generator) -> Array:
    yaw = rng.uniform(-np.pi, np.pi)
    return np.array([*rng.uniform(-1.0, 1.0, 2), np.sin(yaw), np.cos(yaw), 0.0, 0.0, 0.0])


def _goals(robot: Robot, rng: np.random.Generator) -> Setting:
    start = _parked(rng)
    return GoalAfterGoal(robot, rng, reach=2.0, fastest=1.6), start


def _random_driving(robot: Robot, rng: np.random.Generator) -> Setting:
    noise = ColouredNoise(np.array([0.22, 1.0]), 0.5, robot.dt, rng)
    return RandomDriving(robot, noise, SPEED_LIMIT), _parked(rng)
