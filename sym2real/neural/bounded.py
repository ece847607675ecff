"""A network whose outputs stay within bounds everywhere.

A network with ReLU grows without end outside its data, and a rollout that leaves them grows with it. The bounds are one
more layer, ``y = low + relu(x - low) - relu(x - high)``, so that whatever runs a residual runs this one.
"""

from collections.abc import Sequence

import torch
from torch import Tensor

Layer = tuple[Tensor, Tensor]
BEYOND = 0.5  # of the range of outputs, allowed at either end


def bounded(layers: Sequence[Layer], outputs: Tensor) -> list[Layer]:
    """Layers whose outputs stay within the range of those on the rows of a training, and half of it beyond.

    Args:
        layers: weights ``# (in, out)`` and biases ``# (out,)``.
        outputs: on the rows ``# (rows, n)``.
    """
    low, high = outputs.amin(0), outputs.amax(0)
    low, high = low - BEYOND * (high - low), high + BEYOND * (high - low)
    *below, (weight, bias) = layers
    unit = torch.eye(len(bias), dtype=bias.dtype)
    return [*below, (weight.repeat(1, 2), torch.cat([bias - low, bias - high])), (torch.cat([unit, -unit]), low)]


def unbounded(layers: Sequence[Layer]) -> list[Layer]:
    """The layers below the bounds of :func:`bounded`, whose outputs may have been scaled since."""
    *below, (weight, bias), (last, low) = layers
    size = len(low)
    scale = last[:size].diagonal()
    return [*below, (weight[:, :size] * scale, bias[:size] * scale + low)]
