"""Which columns of a residual stay: those without which validation becomes worse beyond chance."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.layout import Layout
from sym2real.neural.batch import Batch
from sym2real.neural.multi_step import corrected_errors, rolled_errors
from sym2real.neural.paired import SURE, sureness


@torch.no_grad()
def columns_that_help(batch: Batch, outputs: Tensor, layout: Layout) -> Tensor:
    """Whether each state column's residual stays ``# (n,)``; quaternions and circles stay or go as a whole.

    Backward elimination: the group whose absence is felt least is switched off until all that are left help. Errors are
    linear in the residual, so every choice is scored exactly without running a network again.

    Args:
        batch: rows that taught nothing.
        outputs: of one network there ``# (rows, n)``.
        layout: of the state.
    """
    steps = len(batch.scale)
    added = batch.moved * outputs[:, None, :]
    parts = corrected_errors(0 * batch.error, added, batch.carried, batch.starts, steps) / batch.scale
    base = rolled_errors(batch.error, batch.carried, batch.starts, steps)[..., 0] / batch.scale[..., 0]
    groups = [layout.indices(columns) for columns in _groups(layout)]
    on = torch.ones(len(layout), dtype=torch.bool)
    while groups:
        best = _by_block(batch, base + parts[..., on].sum(-1))
        gains = []
        for group in groups:
            without = on.clone()
            without[group] = False
            gains.append(sureness(_by_block(batch, base + parts[..., without].sum(-1)) - best))
        least = min(range(len(groups)), key=gains.__getitem__)
        if gains[least] > SURE:
            break
        on[groups.pop(least)] = False
    return on


def _groups(layout: Layout) -> list[tuple[str, ...]]:
    groups: list[tuple[str, ...]] = []
    for field in layout.fields:
        groups += [(column,) for column in field.columns] if field.kind == "vector" else [field.columns]
    return groups


def _by_block(batch: Batch, errors: Tensor) -> Tensor:
    """Mean squared error of every block ``# (blocks,)`` of errors ``# (steps, windows, t)``."""
    windows = errors.square().mean((0, 2))
    blocks = int(batch.block.max()) + 1
    total = torch.zeros(blocks).index_add_(0, batch.block, windows)
    return total / torch.bincount(batch.block, minlength=blocks)
