"""A simulated robot whose sensors are noisy, with the noise of an episode's seed: the same seed flies the same way."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sym2real.experiments.standard_conditions import sensors
from sym2real.plants import MujocoPlant
from sym2real.trajectory import Array


class NoisyPlant(MujocoPlant):
    """Position 0.5 mm, attitude 0.3°, rates 0.02 rad/s, velocity by differences.

    Args:
        plant: without noise. Its own sensor effects act on what is measured.
    """

    def __init__(self, plant: MujocoPlant) -> None:
        self._rng = np.random.default_rng(0)
        changes = (sensors(plant.robot, self._rng), *plant.changes)
        super().__init__(plant.robot, changes, description=plant.description)

    def reset(self, state: ArrayLike | None = None, seed: int | None = None) -> Array:
        """Start an episode with the noise of this seed; the measured state ``# (state,)``."""
        self._rng.bit_generator.state = np.random.default_rng(seed or 0).bit_generator.state
        return super().reset(state)
