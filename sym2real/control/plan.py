"""What MPPI saw at one step, how plans move on, and how much each rollout counts::

    w_i ∝ exp(-(J_i - min J) / λ)

Source: G. Williams et al., "Information theoretic MPC for model-based reinforcement learning", ICRA 2017.
"""

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True)
class Plan:
    """What MPPI saw at one step: for plots, and for those who ask why it did what it did.

    Args:
        states: after each action, for every sample ``# (N, H, state)``.
        actions: ``# (N, H, action)``.
        costs: total cost of each sample, not finite where a rollout was thrown away ``# (N,)``.
        weights: ``# (N,)``.
    """

    states: Tensor
    actions: Tensor
    costs: Tensor
    weights: Tensor

    @property
    def rejected(self) -> int:
        """How many rollouts were not finite."""
        return int((~self.costs.isfinite()).sum())


def shift(mean: Tensor, steps: int) -> Tensor:
    """A plan ``# (H, action)`` as it stands some steps later; its last action is repeated."""
    if steps <= 0:
        return mean
    by = min(steps, len(mean) - 1)
    return torch.cat([mean[by:], mean[-1:].expand(by, -1)])


def importance_weights(costs: Tensor, temperature: float) -> Tensor:
    """Weights ``# (N,)`` that sum to one for costs ``# (N,)``; a cost that is not finite has no weight.

    All weights are zero where no cost is finite.
    """
    finite = costs.isfinite()
    if not bool(finite.any()):
        return torch.zeros_like(costs)
    usable = costs.masked_fill(~finite, torch.inf)
    return torch.softmax(-(usable - usable.min()) / temperature, dim=0)
