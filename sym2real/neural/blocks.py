"""Rows of logs in blocks of time, some of which validate what the others teach.

Neighbouring rows are nearly alike, and windows overlap: rows drawn at random would validate themselves. So would, a
little, blocks of one trajectory: where there are several, whole ones are left out in turn, as the next will be new.
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
TEACHES = -1  # the fold of a block that is never left out
Run = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Stretches of consecutive rows, ``(first, end)``, and when they are left out to validate.

    Args:
        runs: the blocks.
        fold: of each block; :data:`TEACHES` for one that is never left out.
        steps: rows of a window.
    """

    runs: tuple[Run, ...]
    fold: tuple[int, ...]
    steps: int

    @classmethod
    def of(cls, runs: Sequence[Run], steps: int, seed: int) -> Blocks:
        """One fold, of every fifth block; ``seed`` says which of the first five. A block has 20 rows and two windows.

        Raises:
            ModelError: when there are fewer than two blocks.
        """
        blocks = [block for part in _blocks(runs, steps) for block in part]
        mine = min(EVERY, len(blocks))
        held = (seed + mine // 2) % mine
        return cls(tuple(blocks), tuple(0 if place % mine == held else TEACHES for place in range(len(blocks))), steps)

    @classmethod
    def by_trajectory(cls, runs: Sequence[Run], steps: int, seed: int) -> Blocks:
        """Every run is left out once, in five folds at most; as :meth:`of` where one has half of all rows or more.

        Raises:
            ModelError: when there are fewer than two blocks.
        """
        parts = _blocks(runs, steps)
        lengths = [part[-1][1] - part[0][0] for part in parts]
        if 2 * max(lengths) >= sum(lengths):
            return cls.of(runs, steps, seed)
        fold = [place % EVERY for place, part in enumerate(parts) for _ in part]
        return cls(tuple(block for part in parts for block in part), tuple(fold), steps)

    @property
    def folds(self) -> int:
        """Number of them."""
        return max(self.fold) + 1

    @property
    def training(self) -> tuple[Run, ...]:
        """Blocks outside the first fold."""
        return tuple(block for block, fold in zip(self.runs, self.fold, strict=True) if fold != 0)

    @property
    def validation(self) -> tuple[Run, ...]:
        """Blocks of the first fold."""
        return tuple(block for block, fold in zip(self.runs, self.fold, strict=True) if fold == 0)

    @property
    def starts(self) -> Tensor:
        """First rows of all windows that lie within blocks, a row of the block before each ``# (windows,)``."""
        return torch.cat([windows_in(block, self.steps) for block in self.runs])


def windows_in(block: Run, steps: int) -> Tensor:
    """First rows of the windows of a block; its first row only lies before the first window."""
    return torch.arange(block[0] + 1, block[1] - steps + 1)


def rows_in(blocks: Sequence[Run]) -> Tensor:
    """All rows of blocks ``# (rows,)``."""
    return torch.cat([torch.arange(*block) for block in blocks])


def _blocks(runs: Sequence[Run], steps: int) -> list[list[Run]]:
    """Blocks run by run; a run without a window is left out."""
    size = max(SHORTEST, 2 * steps)
    parts = [[block for block in _divided(run, size) if block[1] - block[0] > steps] for run in runs]
    if sum(map(len, parts)) < 2:
        rows = sum(end - first for first, end in runs)
        raise ModelError(f"training needs at least {2 * size} consecutive transitions, found {rows}")
    return [part for part in parts if part]


def _divided(run: Run, size: int) -> list[Run]:
    """A run in equal parts of about ``size`` rows."""
    first, end = run
    parts = max(1, round((end - first) / size))
    edges = [first + (end - first) * part // parts for part in range(parts + 1)]
    return list(pairwise(edges))
