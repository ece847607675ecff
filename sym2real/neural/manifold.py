"""Unit quaternions and circles of a state as TorchScript reads them; ``Layout`` owns what they mean."""

import torch
from torch import Tensor, nn

from sym2real.layout import Layout


def manifold_of(layout: Layout) -> nn.Module:
    """What puts states ``# (..., n)`` back on the manifold; the identity where every state is on it."""
    starts = [(layout.index(field.columns[0]), field) for field in layout.fields if field.kind != "vector"]
    units = [(first, first + len(field.columns)) for first, field in starts]
    return UnitLength(units) if units else nn.Identity()


class UnitLength(nn.Module):
    """States with unit columns of unit length.

    Args:
        units: first and past-the-last column of everything that has unit length; at least one, since TorchScript
            cannot tell what an empty list would hold.
    """

    def __init__(self, units: list[tuple[int, int]]) -> None:
        super().__init__()
        self.units = units

    def forward(self, values: Tensor) -> Tensor:
        parts = list(torch.unbind(values, -1))
        for first, last in self.units:
            length = torch.linalg.vector_norm(values[..., first:last], dim=-1).clamp(min=1e-12)
            for place in range(first, last):
                parts[place] = parts[place] / length
        return torch.stack(parts, -1)
