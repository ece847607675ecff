"""How much each rollout of MPPI counts.

::

    w_i ∝ exp(-(J_i - min J) / λ)

Source: G. Williams et al., "Information theoretic MPC for model-based reinforcement learning", ICRA 2017.
"""

import torch
from torch import Tensor


def importance_weights(costs: Tensor, temperature: float) -> Tensor:
    """Weights ``# (N,)`` that sum to one for costs ``# (N,)``; a cost that is not finite has no weight.

    All weights are zero where no cost is finite.
    """
    finite = costs.isfinite()
    if not bool(finite.any()):
        return torch.zeros_like(costs)
    usable = costs.masked_fill(~finite, torch.inf)
    return torch.softmax(-(usable - usable.min()) / temperature, dim=0)
