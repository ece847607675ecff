"""Rows of a log in blocks of time, and the fold that each belongs to: what a fold validates, the others have taught.

Neighbouring rows are nearly alike, and windows overlap: rows drawn at random would validate themselves.
"""

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor

from sym2real.errors import ModelError

EVERY = 5  # 20 % validate, as in the paper
SHORTEST = 20  # rows of a block
Run = tuple[int, int]


def blocks_of(runs: Sequence[Run], steps: int, seed: int) -> tuple[list[Run], list[int]]:
    """Stretches of consecutive rows, ``(first, end)``, of at least 20 rows and two windows, and the fold of each.

    Args:
        runs: consecutive rows.
        steps: rows of a window.
        seed: says which blocks are of which fold: every fifth is of one, and with fewer blocks each is one.

    Raises:
        ModelError: when there are fewer than two blocks.
    """
    size = max(SHORTEST, 2 * steps)
    blocks = [block for run in runs for block in _divided(run, size) if block[1] - block[0] > steps]
    if len(blocks) < 2:
        rows = sum(end - first for first, end in runs)
        raise ModelError(f"training needs at least {2 * size} consecutive transitions, found {rows}")
    return blocks, [(place + seed) % min(EVERY, len(blocks)) for place in range(len(blocks))]


def windows_in(block: Run, steps: int) -> Tensor:
    """First rows of the windows of a block; its first row only lies before the first window."""
    return torch.arange(block[0] + 1, block[1] - steps + 1)


def windows_of(blocks: Sequence[Run], folds: Sequence[int], steps: int) -> tuple[Tensor, Tensor]:
    """First rows of all windows of blocks ``# (windows,)``, and the fold of each ``# (windows,)``."""
    windows = [windows_in(block, steps) for block in blocks]
    return torch.cat(windows), torch.cat([torch.full_like(w, fold) for w, fold in zip(windows, folds, strict=True)])


def _divided(run: Run, size: int) -> list[Run]:
    """A run in equal parts of about ``size`` rows."""
    first, end = run
    parts = max(1, round((end - first) / size))
    edges = [first + (end - first) * part // parts for part in range(parts + 1)]
    return list(pairwise(edges))
