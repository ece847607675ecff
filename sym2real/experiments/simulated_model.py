"""The simulator itself as MPPI's model: the best that any model of this plant can do."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.plants import MujocoPlant, rollout_mujoco


class MujocoModel:
    """Rolls actions out from the plant's present physics state, not from the measured state that it is given.

    Forces that act now are held over the horizon: exact for a steady wind.

    Args:
        plant: the plant that the controller flies; it must have no command filters.
        substeps: physics steps per control period; by default the plant's own, or fewer where that changes nothing.
    """

    def __init__(self, plant: MujocoPlant, substeps: int | None = None) -> None:
        self.plant, self.substeps = plant, substeps or plant.robot.description.coarse_substeps or None
        self._pushed = plant.inputs.any() or any(change.force for change in plant.changes)

    def __call__(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """State ``# (N, state)`` after one action ``# (N, action)``."""
        return self.rollout(state, action[:, None], inputs)[:, 0]

    def rollout(
        self, state: Tensor, actions: Tensor, inputs: Tensor | None = None, parameters: Tensor | None = None
    ) -> Tensor:
        """States ``# (N, H, state)`` after each action ``# (N, H, action)``."""
        commands, start = actions.double().cpu().numpy(), self.plant.full_state
        forces = self.plant.forces if self._pushed else None
        states = rollout_mujoco(self.plant, start, commands, forces=forces, substeps=self.substeps)
        return torch.as_tensor(states).to(actions)
