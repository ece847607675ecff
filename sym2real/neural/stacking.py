"""How much of a residual's columns is worth having, by what networks say of rows that they have not seen.

Of each column, or quaternion or circle as a whole, a share from 0 to 1 is taken: the shares that leave the least
squared error on held-out rows. A column that says nothing there gets none; columns that only help together are found
together. Source: L. Breiman, "Stacked regressions", Machine Learning 24, 1996 (non-negative least squares on
cross-validated predictions).
"""

import numpy as np
import torch
from scipy.optimize import lsq_linear
from torch import Tensor

from sym2real.layout import Layout

ROUNDING = 1e-6  # share of the largest column's size: sums are in single precision


def shares(base: Tensor, parts: Tensor, layout: Layout) -> Tensor:
    """Of each state column ``# (n,)``.

    Args:
        base: errors of the base ``# (..., 1)``.
        parts: what each column of held-out residuals adds to them ``# (..., n)``.
        layout: of the state.
    """
    groups = [layout.indices(columns) for columns in _groups(layout)]
    added = torch.stack([parts[..., group].sum(-1) for group in groups], dim=-1).reshape(-1, len(groups)).double()
    size = added.square().sum(0).sqrt()
    upper = torch.linalg.qr(torch.cat([added, -base.reshape(-1, 1).double()], dim=-1), mode="r").R.numpy()
    there = (size > ROUNDING * size.max()).numpy()
    by_column, taken = torch.zeros(len(layout), dtype=base.dtype), np.zeros(len(groups))
    if there.any() and bool(size.isfinite().all()):  # what leads itself out of all bounds has no share
        taken[there] = lsq_linear(upper[:, :-1][:, there], upper[:, -1], (0.0, 1.0)).x
    for group, share in zip(groups, taken, strict=True):
        by_column[group] = float(share)
    return by_column


def _groups(layout: Layout) -> list[tuple[str, ...]]:
    groups: list[tuple[str, ...]] = []
    for field in layout.fields:
        groups += [(column,) for column in field.columns] if field.kind == "vector" else [field.columns]
    return groups
