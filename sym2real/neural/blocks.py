"""Rows of a log in blocks of time, every fifth of which validates what the others teach.

Neighbouring rows are nearly alike, and windows overlap: rows drawn at random would validate themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor

from sym2real.errors import ModelError

EVERY = 5  # 20 % validate, as in the paper
SHORTEST = 20  # rows of a block
Run = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Stretches of consecutive rows, ``(first, end)``, and what they are for.

    Args:
        training, validation: the blocks.
        steps: rows of a window.
    """

    training: tuple[Run, ...]
    validation: tuple[Run, ...]
    steps: int

    @classmethod
    def of(cls, runs: Sequence[Run], steps: int, seed: int) -> Blocks:
        """Blocks of at least 20 rows and two windows; ``seed`` says which of the first five validates.

        Raises:
            ModelError: when there are fewer than two blocks.
        """
        blocks = blocks_of(runs, steps)
        mine = min(EVERY, len(blocks))
        held = {place for place in range(len(blocks)) if place % mine == (seed + mine // 2) % mine}
        return cls(
            tuple(block for place, block in enumerate(blocks) if place not in held),
            tuple(blocks[place] for place in sorted(held)),
            steps,
        )

    def starts(self, blocks: Sequence[Run]) -> Tensor:
        """First rows of all windows that lie within blocks, a row of the block before each ``# (windows,)``."""
        return torch.cat([windows_in(block, self.steps) for block in blocks])


def blocks_of(runs: Sequence[Run], steps: int) -> list[Run]:
    """All blocks, of at least 20 rows and two windows.

    Raises:
        ModelError: when there are fewer than two blocks.
    """
    size = max(SHORTEST, 2 * steps)
    blocks = [block for run in runs for block in _divided(run, size) if block[1] - block[0] > steps]
    if len(blocks) < 2:
        rows = sum(end - first for first, end in runs)
        raise ModelError(f"training needs at least {2 * size} consecutive transitions, found {rows}")
    return blocks


def windows_in(block: Run, steps: int) -> Tensor:
    """First rows of the windows of a block; its first row only lies before the first window."""
    return torch.arange(block[0] + 1, block[1] - steps + 1)


def windows_of(runs: Sequence[Run], steps: int, seed: int) -> tuple[Tensor, Tensor]:
    """First rows of all windows that lie within blocks, and the fold of each: every fifth block is of one fold.

    Returns:
        ``# (windows,)`` and ``# (windows,)``, from 0 to :data:`EVERY`, or fewer where there are fewer blocks.

    Raises:
        ModelError: when there are fewer than two blocks.
    """
    blocks = blocks_of(runs, steps)
    windows = [windows_in(block, steps) for block in blocks]
    folds = [torch.full_like(found, (place + seed) % EVERY) for place, found in enumerate(windows)]
    return torch.cat(windows), torch.cat(folds)


def rows_in(blocks: Sequence[Run]) -> Tensor:
    """All rows of blocks ``# (rows,)``."""
    return torch.cat([torch.arange(*block) for block in blocks])


def _divided(run: Run, size: int) -> list[Run]:
    """A run in equal parts of about ``size`` rows."""
    first, end = run
    parts = max(1, round((end - first) / size))
    edges = [first + (end - first) * part // parts for part in range(parts + 1)]
    return list(pairwise(edges))
