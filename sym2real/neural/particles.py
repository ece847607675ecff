"""Rollouts of a probabilistic ensemble as particles, which spread as the ensemble is unsure.

Every particle moves by one member and draws from the Gaussian that this member predicts. TS∞ leaves a particle with its
member for the whole rollout, so that members that differ stay apart: their disagreement adds up with time. TS1 deals
particles to members anew in every step, so that it averages out. Members always have equally many particles. Source:
K. Chua et al. (PETS), NeurIPS 2018, section 5.1.
"""

from typing import Literal

import torch
from torch import Tensor

from sym2real.errors import ShapeError
from sym2real.generator import generator_of
from sym2real.neural.ensemble import Ensemble

Scheme = Literal["TSinf", "TS1"]


@torch.no_grad()
def particle_rollouts(
    ensemble: Ensemble, state: Tensor, actions: Tensor, particles: int = 20, *, scheme: Scheme = "TSinf", seed: int = 0
) -> Tensor:
    """States after each action ``# (particles, ..., H, n)``, on the manifold.

    Args:
        ensemble: particles of a deterministic one spread by what its members disagree on alone.
        state: start ``# (..., n)``.
        actions: ``# (..., H, m)``; leading dimensions broadcast.
        particles: a multiple of the members.
        scheme: of trajectory sampling.
        seed: of the draws.

    Raises:
        ShapeError: for a number of particles that members cannot share, or no such scheme.
    """
    members = ensemble.networks.count
    if particles < 1 or particles % members:
        raise ShapeError(f"expected a multiple of the {members} members as the number of particles, found {particles}")
    if scheme not in ("TSinf", "TS1"):
        raise ShapeError(f"expected the scheme TSinf or TS1, found {scheme!r}")
    generator = generator_of(seed)
    batch = torch.broadcast_shapes(state.shape[:-1], actions.shape[:-2])
    steps = actions.expand(*batch, *actions.shape[-2:]).reshape(-1, *actions.shape[-2:])
    at = state.expand(*batch, -1).reshape(-1, state.shape[-1]).repeat(particles, 1, 1)
    states = list[Tensor]()
    for step in range(steps.shape[-2]):
        order = torch.arange(particles)[:, None].expand(at.shape[:2])
        if scheme == "TS1":
            order = torch.rand(at.shape[:2], generator=generator).argsort(0)
        dealt = at.gather(0, order[..., None].expand_as(at))
        moved = _moved(ensemble, dealt, steps[:, step].expand(particles, -1, -1), generator)
        at = moved.gather(0, order.argsort(0)[..., None].expand_as(at))
        states.append(at)
    return torch.stack(states, dim=-2).reshape(particles, *batch, len(states), state.shape[-1])


def _moved(ensemble: Ensemble, state: Tensor, action: Tensor, generator: torch.Generator) -> Tensor:
    """Next states ``# (particles, rows, n)``, the first particles being those of the first member, and so on."""
    seen = (torch.cat([state, action], dim=-1) - ensemble.input_mean) / ensemble.input_scale
    own = seen.reshape(ensemble.networks.count, -1, seen.shape[-1])
    outputs = ensemble.networks(own).reshape(*state.shape[:-1], -1)
    change = outputs[..., : ensemble.size]
    if ensemble.probabilistic:
        drawn = torch.randn(change.shape, generator=generator, dtype=change.dtype)
        change = change + (0.5 * ensemble.log_variance(outputs)).exp() * drawn
    following: Tensor = ensemble.manifold(state + change * ensemble.output_scale)
    return following
