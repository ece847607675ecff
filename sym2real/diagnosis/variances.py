"""Variances of sensors and pushes by which residuals are most likely: the minorise–maximise step of the whitening.

θ ← θ √(rᵀC⁻¹A C⁻¹r / tr C⁻¹A), for every variance θ with its part A of the covariance (source: ``whitening.py``). All
that a step needs are products of a segment's few sensitivities with each other and with its residuals, channel by
channel; they are taken once, and hundreds of rows take no part in the steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

STEPS = 15
LEAST, MOST = 1e-8, 1e6


@dataclass(frozen=True, eq=False)
class Products:
    """Sums over the rows of each channel of a segment; the K columns are those of the start, then of the pushes.

    Args:
        columns: of columns with columns ``# (S, C, K·K)``.
        residual: of columns with the residual ``# (S, C, K)``.
        square: of the residual with itself ``# (S, C)``.
        rows: number of each channel ``# (C,)``.
        pushes: number of kinds of push; each has as many columns.
        starts: number of columns of the start.
    """

    columns: Tensor
    residual: Tensor
    square: Tensor
    rows: Tensor
    pushes: int
    starts: int

    @classmethod
    def of(cls, start: Tensor, pushes: Tensor, residuals: Tensor, channel: Tensor) -> Products:
        """From sensitivities and residuals.

        Args:
            start: sensitivity to the start ``# (S, R, n)``.
            pushes: to pushes, kind by kind ``# (S, R, D, P)``.
            residuals: ``# (S, R)``.
            channel: number of the channel of each row, from 0 ``# (R,)``.
        """
        columns = torch.cat([start, pushes.flatten(-2)], dim=-1)
        own = [channel == number for number in range(int(channel.max()) + 1)]
        parts = [(columns[:, rows], residuals[:, rows]) for rows in own]
        return cls(
            columns=torch.stack([(part.mT @ part).flatten(1) for part, _ in parts], dim=1),
            residual=torch.stack([(part.mT @ rest[..., None])[..., 0] for part, rest in parts], dim=1),
            square=torch.stack([rest.square().sum(-1) for _, rest in parts], dim=1),
            rows=torch.stack([rows.sum() for rows in own]),
            pushes=pushes.shape[-2],
            starts=start.shape[-1],
        )

    def weighted(self, factor: Tensor) -> Products:
        """With every segment's residuals times the root of a factor ``# (S,)``."""
        residual, square = self.residual * factor.sqrt()[:, None, None], self.square * factor[:, None]
        return replace(self, residual=residual, square=square)


def most_likely(products: Products, sensor: Tensor, power: Tensor) -> tuple[Tensor, Tensor]:
    """Variances of channels ``# (C,)`` and of pushes ``# (D,)`` after :data:`STEPS` steps from those given."""
    for _ in range(STEPS):
        (squares, trace), (hits, masses) = _factors(products, sensor, power)
        sensor = sensor * (squares / trace).sqrt()
        power = (power * (hits / masses.clamp_min(1e-300)).sqrt()).clamp(LEAST, MOST)
    return sensor, power


def _factors(products: Products, sensor: Tensor, power: Tensor) -> tuple[Tensor, Tensor]:
    """rᵀC⁻¹A C⁻¹r and tr C⁻¹A of every channel ``# (2, C)`` and of every push ``# (2, D)``."""
    weight, size = 1.0 / sensor, products.residual.shape[-1]
    each = (size - products.starts) // products.pushes
    scale = torch.cat([power.new_ones(products.starts), power.sqrt().repeat_interleave(each)])
    inside = (weight @ products.columns).unflatten(-1, (size, size))  # (S, K, K)
    along = weight @ products.residual  # (S, K)
    lower = torch.linalg.cholesky(torch.eye(size, dtype=scale.dtype) + inside * scale * scale[:, None])
    root = torch.linalg.solve_triangular(lower, torch.diag(scale), upper=False)
    spread = root.mT @ root  # covariance of the columns' coefficients
    held = (spread @ along[..., None])[..., 0]
    turned = (products.columns.reshape(-1, size, size) @ _each_channel(held, products)[..., None])[..., 0]
    turned = turned.unflatten(0, (len(held), -1))  # (S, C, K)
    squares = products.square - ((2 * products.residual - turned) * held[:, None]).sum(-1)
    trace = products.rows * weight - weight.square() * (products.columns @ spread.flatten(1)[..., None])[..., 0]
    left = (along - (inside @ held[..., None])[..., 0]).square()
    masses = inside.diagonal(dim1=1, dim2=2) - (root @ inside).square().sum(1)
    of_pushes = torch.stack([left, masses])[..., products.starts :].unflatten(-1, (products.pushes, -1)).sum(-1)
    return torch.stack([squares * weight.square(), trace]).sum(1), of_pushes.sum(1)


def _each_channel(held: Tensor, products: Products) -> Tensor:
    return held[:, None].expand(-1, len(products.rows), -1).flatten(0, 1)
