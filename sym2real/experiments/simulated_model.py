"""The simulator itself as MPPI's model: the best that any model of this plant can do."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.plants import MujocoPlant, rollout_mujoco


class MujocoModel:
    """Rolls actions out from the plant's present physics state, not from the measured state that it is given.

    Args:
        plant: the plant that the controller flies; it must have no callbacks or filters.
        substeps: physics steps per control period; the plant's own by default (see ``rollout_mujoco``).
    """

    def __init__(self, plant: MujocoPlant, substeps: int | None = None) -> None:
        self.plant, self.substeps = plant, substeps

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """State ``# (N, state)`` after one action ``# (N, action)``."""
        return self.rollout(state, action[:, None], inputs)[:, 0]

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (N, H, state)`` after each action ``# (N, H, action)``."""
        commands = actions.double().cpu().numpy()
        states = rollout_mujoco(self.plant, self.plant.full_state, commands, substeps=self.substeps)
        return torch.as_tensor(states).to(actions)
