"""Take-off, flights to a place and landing: geometric tracking of a straight line, with an integral of the error.

The geometric controller knows a mass and no model. What the mass or the thrust map is wrong by, the integral takes up,
so that a robot with a fifth of its thrust missing still arrives; a landing, a blind one too, goes on with what the
take-off has learned.
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sym2real.control.geometric_quadrotor import Gains, GeometricQuadrotor, body_axes
from sym2real.errors import ShapeError
from sym2real.robots import Robot
from sym2real.robots.robot import GRAVITY
from sym2real.trajectory import Array

INTEGRAL_RATE = 0.6  # 1/s: m of shift per m of error and s; a third of what the position loop would take
MOST_TRIM = np.array([0.5, 0.5, 1.2])  # m of shift; 8 m/s² of thrust per m
GAINS = Gains()
SPEED = 0.4  # m/s
LEVELLING = 6.0  # 1/s: rad/s of rate per rad of tilt, without a position


@dataclass(frozen=True, eq=False)
class Line:
    """From a point to another at a constant speed, then staying there: yaw 0, upright.

    Args:
        start, end: m, world axes ``# (3,)``.
        speed: m/s.
    """

    start: Array
    end: Array
    speed: float = SPEED

    @property
    def duration(self) -> float:
        """Until the end is reached, s."""
        return float(np.linalg.norm(self.end - self.start)) / self.speed

    def __call__(self, time: Tensor) -> Tensor:
        """State ``# (..., 13)`` at a time in s ``# (...,)``."""
        whole = max(self.duration, 1e-9)
        part = torch.clamp(time / whole, 0.0, 1.0)[..., None]
        start, end = torch.from_numpy(self.start).to(time), torch.from_numpy(self.end).to(time)
        moving = ((part > 0.0) & (part < 1.0)).to(time)
        state = torch.zeros(*time.shape, 13, dtype=time.dtype)
        state[..., 0:3] = start + part * (end - start)
        state[..., 3] = 1.0
        state[..., 7:10] = moving * (end - start) / whole
        return state


class SafeFlight:
    """Flies a quadrotor along lines.

    Args:
        robot: its limits and control period.
        mass: kg; the robot's by default.

    Raises:
        ShapeError: for a mass that its thrust cannot lift, such as one in g, with which it would never come down.
    """

    def __init__(self, robot: Robot, mass: float | None = None) -> None:
        self.robot, self.mass = robot, robot.mass if mass is None else mass
        if not 0.0 < self.mass * GRAVITY < robot.high[0]:
            raise ShapeError(f"expected a mass in kg that {robot.high[0]:g} N lift, found {self.mass:g}")
        self.reset()

    def reset(self) -> None:
        """Forget the integral: a new flight begins."""
        self._trim = np.zeros(3)
        self._steps = 0

    def follow(self, line: Line) -> None:
        """Fly along a line from now on."""
        self._line, self._steps = line, 0
        robot = self.robot
        self._controller = GeometricQuadrotor(self.mass, robot.low, robot.high, robot.dt, line, gains=GAINS)

    def act(self, state: Array) -> Array:
        """Action ``# (4,)`` for a state of finite numbers ``# (13,)``; a call is one control period."""
        wanted = self._wanted()
        shift = self._trim + INTEGRAL_RATE * self.robot.dt * (wanted[0:3] - state[0:3])
        self._trim = np.clip(shift, -MOST_TRIM, MOST_TRIM)
        shifted = state.copy()
        shifted[0:3] -= self._trim
        shifted[3:7] /= np.linalg.norm(shifted[3:7])
        action = self._controller.act(shifted, self._steps)
        self._steps += 1
        return action

    def away(self, state: Array) -> float:
        """How far in m a state ``# (13,)`` is from the line's present point."""
        return float(np.linalg.norm(state[0:3] - self._wanted()[0:3]))

    def _wanted(self) -> Array:
        return self._line(torch.tensor(self._steps * self.robot.dt, dtype=torch.float64)).numpy()

    @property
    def hover(self) -> float:
        """Thrust that holds the weight, by what the integral has learned so far, N."""
        return float(self.mass * (GRAVITY + GAINS.position * self._trim[2]))

    def level(self, attitude: Array | None, part_of_weight: float) -> Array:
        """Action ``# (4,)`` that turns upright without a position; without an attitude too, it stops turning.

        Args:
            attitude: quaternion w x y z, body→world ``# (4,)``, or None where it is not known.
            part_of_weight: thrust as a part of :attr:`hover`.
        """
        rates = np.zeros(3)
        if attitude is not None:
            up = body_axes(attitude / np.linalg.norm(attitude))[2]  # the world's z axis in body axes
            rates[:2] = LEVELLING * np.array([-up[1], up[0]])  # the body's z axis × up
        return np.array([part_of_weight * self.hover, *rates])
