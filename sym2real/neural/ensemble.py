"""The neural baseline of the paper: an ensemble of four multilayer perceptrons, 4 × 200, that predict the next state.

::

    s' = normalise(s + mean over members of r_i(s, a))
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from sym2real.errors import ShapeError
from sym2real.layout import Layouts


class Ensemble(nn.Module):
    """Next state ``# (..., n)`` for state ``# (..., n)`` and action ``# (..., m)``.

    Args:
        layouts: state and action columns.
        members: networks.
        widths: of each network's hidden layers.
        seed: of the first weights.

    Raises:
        ShapeError: without a member, or with a hidden layer of no unit.
    """

    def __init__(
        self, layouts: Layouts, members: int = 4, widths: Sequence[int] = (200, 200, 200, 200), seed: int = 0
    ) -> None:
        super().__init__()
        if min((members, *widths)) < 1:
            raise ShapeError(f"expected members and hidden layers of at least one unit, found {members}, {(*widths,)}")
        self.layouts, self.state = layouts, layouts.state
        generator = torch.Generator().manual_seed(seed)
        sizes = (len(layouts.state) + len(layouts.action), *widths, len(layouts.state))
        self.weights, self.biases = nn.ParameterList(), nn.ParameterList()
        for seen, out in pairwise(sizes):
            bound = (6.0 / seen) ** 0.5
            self.weights.append(nn.Parameter(bound * (2 * torch.rand(members, seen, out, generator=generator) - 1)))
            self.biases.append(nn.Parameter(torch.zeros(members, 1, out)))

    def members(self, state: Tensor, action: Tensor) -> Tensor:
        """Change of the state that each member predicts ``# (members, ..., n)``."""
        batch = torch.broadcast_shapes(state.shape[:-1], action.shape[:-1])
        both = torch.cat([state.expand(*batch, -1), action.expand(*batch, -1)], dim=-1)
        values = both.reshape(1, -1, both.shape[-1]).expand(len(self.weights[0]), -1, -1)
        for place, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = torch.baddbmm(bias, torch.relu(values) if place else values, weight)
        return values.reshape(-1, *batch, values.shape[-1])

    def forward(self, state: Tensor, action: Tensor, inputs: Tensor | None = None) -> Tensor:
        """Next state on the manifold; leading dimensions broadcast."""
        return self.state.normalise(state + self.members(state, action).mean(dim=0))
