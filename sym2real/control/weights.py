"""How much each rollout of MPPI counts.

::

    w_i ∝ exp(-(J_i - min J) / λ)

Source: G. Williams et al., "Information theoretic MPC for model-based reinforcement learning", ICRA 2017.
"""

from __future__ import annotations

import torch
from torch import Tensor


def weigh(costs: Tensor, temperature: float) -> Tensor:
    """Weights ``# (N,)`` that sum to one for costs ``# (N,)``; a cost that is not finite weighs nothing.

    All weights are zero where no cost is finite.
    """
    finite = costs.isfinite()
    if not bool(finite.any()):
        return torch.zeros_like(costs)
    usable = costs.masked_fill(~finite, torch.inf)
    return torch.softmax(-(usable - usable.min()) / temperature, dim=0)


def control_cost(mean: Tensor, noise: Tensor, factor: Tensor, temperature: float) -> Tensor:
    """Information-theoretic price ``# (N,)`` of noise around a mean: λ Σ_t u_t^T Σ^-1 δ_t, with Σ = C C^T.

    Args:
        mean: ``# (H, m)``.
        noise: ``# (N, H, m)``.
        factor: C ``# (m, m)``.
        temperature: λ.
    """
    return temperature * (noise * whitened(mean, factor)).sum((-2, -1))


def whitened(mean: Tensor, factor: Tensor) -> Tensor:
    """Σ^-1 u ``# (H, m)`` of a mean u ``# (H, m)``, with Σ = C C^T."""
    return torch.cholesky_solve(mean.T, factor).T.contiguous()
