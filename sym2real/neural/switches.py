"""Which columns of a residual stay, by what they take off the errors of rows that they were not taught."""

from __future__ import annotations

import torch
from torch import Tensor

from sym2real.layout import Layout
from sym2real.neural.batch import Batch
from sym2real.neural.multi_step import corrected_errors, rolled_errors
from sym2real.neural.paired import SURE, simplest, sureness

# Share of the squared error that a residual must take away. Tuned on simulated flights whose base is right: velocities
# by differences and a drifting motion capture let 0.01 to 0.03 be learned that holds for that task alone.
LEAST = 0.05


@torch.no_grad()
def columns_that_help(batch: Batch, outputs: Tensor, layout: Layout) -> Tensor:
    """Whether each state column's residual stays ``# (n,)``; quaternions and circles stay or go as a whole.

    Backward elimination from all columns to none: the group whose absence is felt least goes first. Of the sets on this
    path that are surely better than none, and by a twentieth, the smallest stays that is within a standard error of the
    best: so columns stay which help only together. Errors are linear in the residual, so every set is scored exactly
    without running a network again.

    Args:
        batch: rows that taught nothing.
        outputs: of one network there ``# (rows, n)``.
        layout: of the state.
    """
    steps = len(batch.scale)
    added = batch.moved * outputs[:, None, :]
    parts = corrected_errors(0 * batch.error, added, batch.carried, batch.starts, steps) / batch.scale
    base = rolled_errors(batch.error, batch.carried, batch.starts, steps)[..., 0] / batch.scale[..., 0]

    def error(on: Tensor) -> Tensor:
        return _by_block(batch, base + parts[..., on].sum(-1))

    groups = [layout.indices(columns) for columns in _groups(layout)]
    path = [torch.ones(len(layout), dtype=torch.bool)]
    while groups:
        fewer = [path[0].index_fill(0, torch.tensor(group), False) for group in groups]
        least = min(range(len(groups)), key=lambda place: float(error(fewer[place]).mean()))
        path.insert(0, fewer[least])
        groups.pop(least)
    errors = [error(on) for on in path]
    none = errors[0]
    helpful = [
        place
        for place, some in enumerate(errors)
        if place == 0 or (sureness(none - some) > SURE and some.mean() < (1.0 - LEAST) * none.mean())
    ]
    return path[helpful[simplest([errors[place] for place in helpful])]]


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
