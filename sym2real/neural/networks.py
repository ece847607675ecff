"""Several multilayer perceptrons of one shape, computed and trained together by batched matrix products."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from sym2real.errors import ShapeError


class Networks(nn.Module):
    """``count`` networks with ReLU between their layers, each with weights of its own.

    Args:
        sizes: columns that they see, hidden layers, outputs.
        count: of networks.
        seed: of the first weights (K. He et al., "Delving deep into rectifiers", ICCV 2015).

    Raises:
        ShapeError: without a network, or with a layer of no unit.
    """

    def __init__(self, sizes: Sequence[int], count: int, seed: int = 0) -> None:
        super().__init__()
        if min((count, *sizes)) < 1:
            raise ShapeError(f"expected networks and layers of at least one unit, found {count} of {(*sizes,)}")
        self.count = count
        generator = torch.Generator().manual_seed(seed)
        self.weights, self.biases = nn.ParameterList(), nn.ParameterList()
        for seen, out in pairwise(sizes):
            bound = (6.0 / seen) ** 0.5
            self.weights.append(nn.Parameter(bound * (2 * torch.rand(count, seen, out, generator=generator) - 1)))
            self.biases.append(nn.Parameter(torch.zeros(count, 1, out)))

    def forward(self, values: Tensor) -> Tensor:
        """Outputs ``# (count, rows, out)`` for the same rows ``# (rows, seen)`` or each network's own."""
        values = values.expand(self.count, -1, -1)
        for place, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = torch.baddbmm(bias, torch.relu(values) if place else values, weight)
        return values
