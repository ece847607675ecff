"""Random commands: the first episode of Stage I, flown before there is any model."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sym2real.protocols import Memoryless
from sym2real.robots.robot import Robot
from sym2real.trajectory import Array


@dataclass(frozen=True)
class RandomCommands(Memoryless):
    """Actions uniform over ``robot.limits.random_low`` … ``robot.limits.random_high``, each held for a while.

    Args:
        robot: gives the ranges and the control period.
        hold: how long an action is held, s.
        seed: the same seed gives the same sequence in every episode.
    """

    robot: Robot
    hold: float = 0.2
    seed: int = 0

    def act(self, state: ArrayLike, step: int, inputs: ArrayLike | None = None) -> Array:
        """Action ``# (action,)`` of this step, whatever the state."""
        held = max(1, round(self.hold / self.robot.dt))
        draw = np.random.default_rng([self.seed, step // held])
        return draw.uniform(self.robot.limits.random_low, self.robot.limits.random_high)
