"""How segments are parted: folds that are left out together, blocks that are independent of each other."""

from __future__ import annotations

from math import ceil

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import Segments

# Folds of the cross-validation where there are fewer logs.
FEWEST_FOLDS = 4
BLOCK_SECONDS, GAP_SECONDS = 1.0, 0.5


def folds_of(segments: Segments) -> NDArray[np.int64]:
    """Fold of every segment ``# (S,)``: leave one log out; few logs are parted further in time."""
    log = segments.log
    parts = max(1, ceil(FEWEST_FOLDS / len(np.unique(log))))
    folds = np.zeros(len(log), dtype=np.int64)
    for index in np.unique(log):
        mine = np.flatnonzero(log == index)
        folds[mine] = index * parts + np.arange(len(mine)) * parts // len(mine)
    return np.unique(folds, return_inverse=True)[1].astype(np.int64)


def summed(values: Tensor, parts: NDArray[np.int64]) -> Tensor:
    """Sums over parts ``# (parts, ...)`` of what every segment has ``# (S, ...)``; -1 is no part ``# (S,)``."""
    used, count = torch.as_tensor(parts >= 0), int(parts.max()) + 1
    return values.new_zeros(count, *values.shape[1:]).index_add(0, torch.as_tensor(parts)[used], values[used])


def blocks_of(segments: Segments, dt: float) -> NDArray[np.int64]:
    """Block of every segment, -1 in the gaps between them ``# (S,)``; a log's last block may be shorter.

    Args:
        segments: in the order of their logs.
        dt: time step in s.
    """
    seconds = segments.length * dt
    inside, gap = ceil(BLOCK_SECONDS / seconds - 1e-9), ceil(GAP_SECONDS / seconds - 1e-9)
    blocks = np.full(len(segments), -1, dtype=np.int64)
    count = 0
    for index in np.unique(segments.log):
        mine = np.flatnonzero(segments.log == index)
        for first in range(0, len(mine), inside + gap):
            blocks[mine[first : first + inside]] = count
            count += 1
    return blocks
