"""Most likely variances of sensors and disturbances: the minorise–maximise step of the whitening.

θ ← θ √(rᵀC⁻¹A C⁻¹r / tr C⁻¹A), for every variance θ with its part A of the covariance (source: ``whitening.py``). What
a step needs are products of a segment's few sensitivities with each other and with its residuals, channel by channel,
which are taken once, and the residuals that are left, row by row. All that could be said as a difference of products is
said otherwise: where a base runs away, residuals are a million times the noise, and a difference has no digit left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from sym2real.least_squares import root_plus_identity
from sym2real.logs.noise import SMALLEST_NOISE

STEPS = 15
LEAST, MOST = 1e-8, 1e6


@dataclass(frozen=True, eq=False)
class Products:
    """A segment's K sensitivities, to the start and then to the disturbances, and sums over the rows of each channel.

    Args:
        columns: sensitivities ``# (S, R, K)``.
        residuals: ``# (S, R)``.
        channel: number of the channel of each row, from 0 ``# (R,)``.
        inner: of columns with columns, by channel ``# (S, C, K·K)``.
        outer: of columns with the residual, by channel ``# (S, C, K)``.
        disturbances: number of kinds of disturbance; each has as many columns.
        starts: number of columns of the start.
    """

    columns: Tensor
    residuals: Tensor
    channel: Tensor
    inner: Tensor
    outer: Tensor
    disturbances: int
    starts: int

    @classmethod
    def of(cls, start: Tensor, disturbances: Tensor, residuals: Tensor, channel: Tensor) -> Products:
        """From sensitivities and residuals.

        Args:
            start: sensitivity to the start ``# (S, R, n)``.
            disturbances: to disturbances, kind by kind ``# (S, R, D, P)``.
            residuals: ``# (S, R)``.
            channel: number of the channel of each row, from 0 ``# (R,)``.
        """
        columns = torch.cat([start, disturbances.flatten(-2)], dim=-1)
        own = [channel == number for number in range(int(channel.max()) + 1)]
        parts = [(columns[:, rows], residuals[:, rows]) for rows in own]
        return cls(
            columns=columns,
            residuals=residuals,
            channel=channel,
            inner=torch.stack([(part.mT @ part).flatten(1) for part, _ in parts], dim=1),
            outer=torch.stack([(part.mT @ rest[..., None])[..., 0] for part, rest in parts], dim=1),
            disturbances=disturbances.shape[-2],
            starts=start.shape[-1],
        )

    def weighted(self, factor: Tensor) -> Products:
        """With every segment's residuals times the root of a factor ``# (S,)``."""
        root = factor.sqrt()[:, None]
        return replace(self, residuals=self.residuals * root, outer=self.outer * root[..., None])


def most_likely(products: Products, sensor: Tensor, power: Tensor) -> tuple[Tensor, Tensor]:
    """Variances of channels ``# (C,)`` and of disturbances ``# (D,)`` after :data:`STEPS` steps from those given."""
    for _ in range(STEPS):
        (squares, trace), (hits, masses) = _factors(products, sensor, power)
        sensor = (sensor * (squares / trace).sqrt()).clamp_min(SMALLEST_NOISE**2)  # what stands still misses nothing
        power = (power * (hits / masses.clamp_min(1e-300)).sqrt()).clamp(LEAST, MOST)
    return sensor, power


def _factors(products: Products, sensor: Tensor, power: Tensor) -> tuple[Tensor, Tensor]:
    """rᵀC⁻¹A C⁻¹r and tr C⁻¹A of every channel ``# (2, C)`` and of every disturbance ``# (2, D)``.

    With the columns G, their deviations s and M = 1 + s GᵀΣ⁻¹G s: GᵀC⁻¹r = M⁻¹ s GᵀΣ⁻¹r / s, GᵀC⁻¹G = (1 - M⁻¹) / s².
    """
    weight, size = 1.0 / sensor, products.outer.shape[-1]
    each = (size - products.starts) // products.disturbances
    scale = torch.cat([power.new_ones(products.starts), power.sqrt().repeat_interleave(each)])
    inside = (weight @ products.inner).unflatten(-1, (size, size))  # (S, K, K)
    along = weight @ products.outer  # (S, K)
    unit = torch.eye(size, dtype=scale.dtype)
    root = torch.linalg.solve_triangular(root_plus_identity(inside * scale * scale[:, None]), unit, upper=False)
    spread = scale * (root.mT @ root) * scale[:, None]  # covariance of the columns' coefficients
    held = (spread @ along[..., None])[..., 0]
    left = products.residuals - (products.columns @ held[..., None])[..., 0]
    squares = products.channel.bincount(left.square().sum(0)) * weight.square()
    lost = (products.inner @ spread.flatten(1)[..., None])[..., 0].sum(0)
    trace = len(left) * products.channel.bincount() * weight - weight.square() * lost
    hits = (held / scale.square()).square()
    masses = (1.0 - root.square().sum(1)) / scale.square()
    disturbed = torch.stack([hits, masses]).sum(1)[:, products.starts :]
    return torch.stack([squares, trace]), disturbed.unflatten(-1, (products.disturbances, -1)).sum(-1)
