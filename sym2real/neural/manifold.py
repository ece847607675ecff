"""Unit quaternions and circles of a state as TorchScript reads them; ``Layout`` owns what they mean."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.layout import Layout


def units_of(layout: Layout) -> list[tuple[int, int]]:
    """First and past-the-last column of everything that has unit length."""
    starts = [(layout.index(field.columns[0]), field) for field in layout.fields if field.kind != "vector"]
    return [(first, first + len(field.columns)) for first, field in starts]


def on_manifold(values: Tensor, units: list[tuple[int, int]]) -> Tensor:
    """Values ``# (..., n)`` with unit columns of unit length."""
    parts = list(torch.unbind(values, -1))
    for first, last in units:
        length = torch.linalg.vector_norm(values[..., first:last], dim=-1).clamp(min=1e-12)
        for place in range(first, last):
            parts[place] = parts[place] / length
    return torch.stack(parts, -1)
