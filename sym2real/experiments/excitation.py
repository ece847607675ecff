"""What excites in test runs: noise, and controllers with random commands of their own."""

from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.control import Disturbed
from sym2real.protocols import Controller, Memoryless
from sym2real.robots import Robot
from sym2real.rotation import to_matrix
from sym2real.trajectory import Array

DITHER_TIME = 0.1  # s
PATIENCE = 6.0  # s for a goal


class ColouredNoise:
    """An Ornstein–Uhlenbeck process, started in its stationary distribution.

    Args:
        deviation: standard deviation per column ``# (columns,)``.
        correlation: time constant in s.
        dt: time step in s.
        rng: where the numbers come from.
    """

    def __init__(self, deviation: Array, correlation: float, dt: float, rng: np.random.Generator) -> None:
        self._deviation, self._kept, self._rng = deviation, float(np.exp(-dt / correlation)), rng
        self._value = self._drawn()

    def _drawn(self) -> Array:
        return self._deviation * self._rng.standard_normal(self._deviation.shape)

    def next(self, _: int = 0) -> Array:
        """The present value ``# (columns,)``, whatever the step that a caller counts; then the process goes on."""
        present = self._value
        self._value = self._kept * present + np.sqrt(1.0 - self._kept**2) * self._drawn()
        return present


def dithered(controller: Controller, robot: Robot, rng: np.random.Generator, factor: float = 1.0) -> Disturbed:
    """A controller with the dither of a robot's recipe on its commands, by a factor."""
    noise = ColouredNoise(factor * np.array(robot.recipe.dither), DITHER_TIME, robot.dt, rng)
    return Disturbed(controller, noise.next, robot.low, robot.high)


@dataclass
class RandomRates(Memoryless):
    """A quadrotor's random thrust and body rates, each held for a while.

    Args:
        robot: gives limits and control period.
        rng: where the numbers come from.
        levelling: 1/s of rate command per rad of tilt, against it; 0 lets the vehicle tumble.
        climbing: 1/s² of vertical acceleration per m below the height of the start; 0 lets it fall.
        hold: in s.
    """

    robot: Robot
    rng: np.random.Generator
    levelling: float = 0.0
    climbing: float = 0.0
    hold: float = 0.2
    _drawn: Array = field(init=False, default_factory=lambda: np.zeros(4))
    _height: float = field(init=False, default=0.0)

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)``."""
        measured = np.asarray(state, dtype=np.float64)
        if step == 0:
            self._height = float(measured[2])
        if step % max(1, round(self.hold / self.robot.dt)) == 0:
            self._drawn = self.rng.uniform(self.robot.limits.random_low, self.robot.limits.random_high)
        matrix = to_matrix(torch.as_tensor(measured[3:7])).numpy()
        # The world's vertical in body axes: its x and y parts are the sines of the tilt to be turned back.
        up = matrix[2]
        lift = self.climbing * (self._height - measured[2]) - np.sqrt(2.0 * self.climbing) * measured[9]
        feedback = np.array([self.robot.mass * lift, -self.levelling * up[1], self.levelling * up[0], 0.0])
        clipped: Array = np.clip(self._drawn + feedback, self.robot.low, self.robot.high)
        return clipped


@dataclass
class RandomDriving(Memoryless):
    """A car's random steering about straight on and random speed about 1 m/s, forward only.

    Args:
        robot: gives the steering limits.
        noise: of steering in rad and speed in m/s.
        fastest: in m/s.
    """

    robot: Robot
    noise: ColouredNoise
    fastest: float

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Steering and speed ``# (2,)``, whatever the state."""
        steer, change = self.noise.next()
        limit = self.robot.high[0]
        return np.array([np.clip(steer, -limit, limit), np.clip(1.0 + change, 0.0, self.fastest)])


@dataclass
class GoalAfterGoal(Memoryless):
    """A car drives forward to random goals, a new one on arrival or after a while.

    Args:
        robot: gives the steering limits and the control period.
        rng: where the goals come from.
        reach: goals lie in ±reach of the origin, m.
        fastest: in m/s.
    """

    robot: Robot
    rng: np.random.Generator
    reach: float
    fastest: float
    _goal: Array = field(init=False, default_factory=lambda: np.zeros(2))
    _left: int = field(init=False, default=0)

    def reset(self) -> None:
        """The next step draws a new goal."""
        self._left = 0

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` for a measured state ``# (state,)``."""
        x, y, sine, cosine = np.asarray(state, dtype=np.float64)[:4]
        if self._left == 0 or np.hypot(*(self._goal - [x, y])) < 0.3:
            self._goal = self.rng.uniform(-self.reach, self.reach, 2)
            self._left = round(PATIENCE / self.robot.dt)
        self._left -= 1
        ahead = self._goal - [x, y]
        forward, left = ahead[0] * cosine + ahead[1] * sine, ahead[1] * cosine - ahead[0] * sine
        steer = np.clip(np.arctan2(left, forward), self.robot.low[0], self.robot.high[0])
        return np.array([steer, min(0.5 + np.hypot(forward, left), self.fastest)])


def unlimited(robot: Robot) -> Robot:
    """The robot without limits but its actuators' own: test drives go faster than a controller may ask for."""
    return robot.within(np.full_like(robot.low, -np.inf), np.full_like(robot.high, np.inf))
