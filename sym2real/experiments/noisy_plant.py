"""A simulated robot whose sensors are noisy, with the noise of an episode's seed: the same seed flies the same way."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sym2real.experiments.standard_conditions import sensors
from sym2real.layout import Layouts
from sym2real.plants import MujocoPlant
from sym2real.trajectory import Array


class NoisyPlant:
    """A :class:`~sym2real.protocols.Plant`: position 0.5 mm, attitude 0.3°, rates 0.02 rad/s, velocity by differences.

    Args:
        plant: without noise. Its own sensor effects act on what is measured.
    """

    def __init__(self, plant: MujocoPlant) -> None:
        self._rng = np.random.default_rng(0)
        changes = (sensors(plant.robot, self._rng), *plant.changes)
        self._plant = MujocoPlant(plant.robot, changes, description=plant.description)
        self.robot, self.changes, self.description = plant.robot, changes, plant.description

    @property
    def layouts(self) -> Layouts:
        """The robot's columns."""
        return self._plant.layouts

    @property
    def dt(self) -> float:
        """Control period in s."""
        return self._plant.dt

    @property
    def inputs(self) -> Array:
        """The wrench that acts now ``# (inputs,)``."""
        return self._plant.inputs

    @property
    def crashed(self) -> bool:
        """Whether the robot has touched the ground, or rolled over, since the reset."""
        return self._plant.crashed

    @property
    def sent(self) -> Array:
        """The last action within the robot's limits ``# (action,)``."""
        return self._plant.sent

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode with the noise of this seed; the measured state ``# (state,)``."""
        self._rng.bit_generator.state = np.random.default_rng(seed or 0).bit_generator.state
        return self._plant.reset(state)

    def step(self, action: ArrayLike) -> Array:
        """Measured state ``# (state,)`` after one action ``# (action,)``."""
        return self._plant.step(action)
