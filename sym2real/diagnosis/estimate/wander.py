"""A sensor that wanders: noise whose next value goes on from the last, as the errors of an estimator do."""

from dataclasses import dataclass, field
from functools import cached_property

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Wander:
    """Noise that goes on from row to row: beside the white noise σ of a component, a random walk of steps √ρ σ.

    Args:
        shares: ρ of each component ``# (C,)``.
        length: rows of a segment.
    """

    shares: Tensor = field(default_factory=lambda: torch.zeros(0, dtype=torch.float64))
    length: int = 0

    @property
    def walks(self) -> bool:
        """Whether any component does."""
        return bool(self.shares.any())

    @cached_property
    def _modes(self) -> tuple[Tensor, Tensor]:
        """Combinations of rows in which white noise and walks are both independent, and variances of both together."""
        rows = torch.arange(1.0, self.length + 1, dtype=torch.float64)
        sizes, modes = torch.linalg.eigh(torch.minimum(rows, rows[:, None]))
        return modes, 1.0 + sizes[:, None] * self.shares

    @property
    def determinant(self) -> float:
        """Logarithm of that of a segment's noise, in units of the white noise."""
        return float(self._modes[1].log().sum()) if self.walks else 0.0

    def whitened(self, columns: Tensor, *, back: bool = False) -> Tensor:
        """Columns ``# (S, R, A)`` as combinations of rows with white noise; ``back`` is the transpose of that."""
        if not self.walks:
            return columns
        modes, variances = self._modes
        parts = columns.unflatten(1, (self.length, -1))  # (S, N, C, A)
        scale = variances.rsqrt()[..., None]
        parts = parts * scale if back else parts
        turned = ((modes if back else modes.T) @ parts.flatten(2)).reshape(parts.shape)
        return torch.flatten(turned if back else turned * scale, 1, 2)
