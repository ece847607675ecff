"""How simulated manoeuvres are flown and driven whatever the effect: loosely, and never ahead of the robot."""

import numpy as np
import torch
from numpy.typing import ArrayLike

from sym2real.control import PurePursuit
from sym2real.control.geometric_quadrotor import Gains
from sym2real.protocols import Memoryless
from sym2real.robots import Robot
from sym2real.tasks.standard_paths import MODULATION_PERIOD
from sym2real.tasks.task import Reference
from sym2real.trajectory import Array

# Slow enough for a delay of three periods and rotors that lag by 70 ms.
GAINS = Gains(position=5.0, velocity=3.6, attitude=7.0)
CATCHING_UP = 1.15  # largest speed command as a multiple of the path's largest speed
LATE, LOST = 0.1, 0.5  # m behind its place at which the path begins to wait, and stands


class AtItsPace(Memoryless):
    """Pure pursuit of a path that waits for a car which cannot keep up (sliding, delays).

    Args:
        robot: a car.
        reference: the path.
    """

    def __init__(self, robot: Robot, reference: Reference) -> None:
        self._robot, self._reference = robot, reference
        fastest = CATCHING_UP * _fastest(reference)
        low, high = np.array([robot.low[0], 0.0]), np.array([robot.high[0], min(robot.high[1], fastest)])
        self._pursuit = PurePursuit(robot.numbers["wheelbase"], low, high, robot.dt, reference)
        self.reset()

    def reset(self) -> None:
        """Start the path anew."""
        self.times = [0.0]

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Steering and speed ``# (2,)`` for a measured state ``# (state,)``."""
        times = self.times[-1] + torch.tensor([0.0, self._pursuit.lookahead], dtype=torch.float64)
        wanted, ahead = self._reference(times).numpy()
        action = self._pursuit.towards(wanted, ahead, state)
        behind = (wanted[:2] - np.asarray(state)[:2]) @ wanted[[3, 2]]
        pace = np.clip(1.0 - (behind - LATE) / (LOST - LATE), 0.0, 1.0)
        self.times.append(self.times[-1] + float(pace) * self._robot.dt)
        return action

    def wanted(self, rows: int) -> Array:
        """What was pursued, by row ``# (rows, state)``."""
        return self._reference(torch.tensor(self.times[:rows], dtype=torch.float64)).numpy()


def _fastest(reference: Reference) -> float:
    speeds = reference(torch.linspace(0.0, MODULATION_PERIOD, 100, dtype=torch.float64))[:, 4:6].norm(dim=-1)
    return float(speeds.max())
