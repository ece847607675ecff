"""Several multilayer perceptrons of one shape, computed and trained together by batched matrix products."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from sym2real.errors import ShapeError
from sym2real.generator import generator_of

PAPER = (200, 200, 200, 200)  # the paper's hidden layers


class Layer(nn.Module):
    """Affine maps, one a network; arguments as of :class:`Networks`."""

    def __init__(self, seen: int, out: int, count: int, generator: torch.Generator) -> None:
        super().__init__()
        bound = (6.0 / seen) ** 0.5
        self.weight = nn.Parameter(
            bound * (2 * torch.rand(count, seen, out, generator=generator, dtype=torch.float32) - 1)
        )
        self.bias = nn.Parameter(torch.zeros(count, 1, out, dtype=torch.float32))

    def forward(self, values: Tensor) -> Tensor:
        """``# (count, rows, out)`` for ``# (count, rows, seen)``."""
        return torch.baddbmm(self.bias, values, self.weight)


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
        generator = generator_of(seed)
        self.layers = nn.ModuleList(Layer(seen, out, count, generator) for seen, out in pairwise(sizes))

    @torch.no_grad()
    def pairs(self) -> list[tuple[Tensor, Tensor]]:
        """Weights ``# (count, in, out)`` and biases ``# (count, 1, out)`` of every layer, as they are."""
        return [(layer.weight, layer.bias) for layer in self.layers if isinstance(layer, Layer)]

    def forward(self, values: Tensor) -> Tensor:
        """Outputs ``# (count, rows, out)`` for the same rows ``# (rows, seen)`` or each network's own."""
        if values.dim() == 2:
            values = values[None].expand(self.count, -1, -1)
        for place, layer in enumerate(self.layers):
            values = layer(values if place == 0 else torch.relu(values))
        return values

    def only(self, which: Tensor) -> Networks:
        """Some of them, with the weights that they have.

        Args:
            which: their numbers ``# (some,)``.
        """
        pairs = self.pairs()
        chosen = Networks([pairs[0][0].shape[1], *(bias.shape[-1] for _, bias in pairs)], len(which))
        chosen.load_state_dict({name: weight[which] for name, weight in self.state_dict().items()})
        return chosen
