"""Gradient descent of several networks at once, each with an early stop of its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from sym2real.neural.networks import Networks

BETWEEN = 10  # steps between validations


@dataclass(frozen=True)
class Descent:
    """How weights are found.

    Args:
        steps: of AdamW at most.
        learning_rate: at the start; it falls to zero along a cosine.
        weight_decay: of AdamW, the paper's.
        rows: of a step; all rows where there are no more.
        patience: validations without improvement after which a network is finished; 10 steps lie between two.
    """

    steps: int = 300
    learning_rate: float = 1e-2
    weight_decay: float = 5e-5
    rows: int = 512
    patience: int = 15


def descend(
    networks: Networks,
    loss: Callable[[int], Tensor],
    validate: Callable[[], Tensor],
    settings: Descent,
    beside: Sequence[nn.Parameter] = (),
) -> Tensor:
    """Train networks, leave each with the weights that validated best, and give those validations ``# (count,)``.

    Args:
        networks: altered in place.
        loss: of each network at a step of the descent ``# (count,)``.
        validate: error of each network ``# (count,)``.
        settings: of the descent.
        beside: weights that the networks share; they descend too, and have no early stop.
    """
    weights = list(networks.parameters())
    optimiser = torch.optim.AdamW([*weights, *beside], settings.learning_rate, weight_decay=settings.weight_decay)
    falling = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.steps)
    with torch.no_grad():
        best, kept = validate(), [weight.clone() for weight in weights]
    since = torch.zeros(networks.count, dtype=torch.int64)
    for step in range(settings.steps):
        optimiser.zero_grad()
        loss(step).sum().backward()
        optimiser.step()
        falling.step()
        if (step + 1) % BETWEEN:
            continue
        with torch.no_grad():
            now = validate()
            better = now < best
            best, since = torch.where(better, now, best), torch.where(better, 0, since + 1)
            kept = [torch.where(better[:, None, None], w, k) for w, k in zip(weights, kept, strict=True)]
        if bool((since >= settings.patience).all()):
            break
    with torch.no_grad():
        for weight, old in zip(weights, kept, strict=True):
            weight.copy_(old)
    return best
