"""Rows that are trained on together, in normalised columns, and the loss of several networks over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from sym2real.neural.blocks import Run, rows_in, windows_in
from sym2real.neural.leftover import Leftover
from sym2real.neural.multi_step import Scales, corrected_errors
from sym2real.neural.networks import Networks
from sym2real.neural.normal import Normal


@dataclass(frozen=True, eq=False)
class Batch:
    """Whole blocks of rows; n state columns, t tangent components.

    Args:
        seen: normalised inputs of the networks ``# (rows, seen)``.
        error: the base's one-step errors ``# (rows, t, 1)``.
        moved: what a network's outputs add to them ``# (rows, t, n)``.
        carried: how errors go on ``# (rows, t, t)``.
        starts: first rows of windows ``# (windows,)``.
        block: which block a window lies in ``# (windows,)``.
        scale: of errors ``# (steps, 1, t, 1)``.
    """

    seen: Tensor
    error: Tensor
    moved: Tensor
    carried: Tensor
    starts: Tensor
    block: Tensor
    scale: Tensor

    @classmethod
    def of(cls, rows: Leftover, blocks: Sequence[Run], normal: Normal, scales: Scales) -> Batch:
        """The rows of some blocks."""
        chosen = rows_in(blocks)
        steps = len(scales.error)
        starts, block, gone = list[Tensor](), list[Tensor](), 0
        for number, (first, end) in enumerate(blocks):
            starts.append(windows_in((gone, gone + end - first), steps))
            block.append(torch.full((len(starts[-1]),), number))
            gone += end - first
        return cls(
            normal(rows.seen[chosen]),
            rows.error[chosen, :, None],
            rows.moved[chosen] * normal.output,
            rows.carried[chosen],
            torch.cat(starts),
            torch.cat(block),
            scales.error,
        )

    def loss(self, outputs: Tensor) -> Tensor:
        """Mean squared error of each network, 1 for the base ``# (count,)``; outputs ``# (count, rows, n)``."""
        added = self.moved @ outputs.permute(1, 2, 0)
        rolled = corrected_errors(self.error, added, self.carried, self.starts, len(self.scale)) / self.scale
        mean: Tensor = rolled.square().mean((0, 1, 2))
        return mean

    def penalised(self, networks: Networks, penalties: Tensor) -> Tensor:
        """Loss and λ·mean squared output of each network ``# (count,)``."""
        outputs = networks(self.seen)
        size: Tensor = penalties * outputs.square().mean((1, 2))
        return self.loss(outputs) + size


class Batches:
    """Batches of blocks in an order that the seed decides, every block once before any comes again.

    Args:
        make: a batch of some blocks.
        blocks: to draw from.
        size: rows of a batch, about; all blocks are one batch where they have no more.
        seed: of the order.
    """

    def __init__(self, make: Callable[[Sequence[Run]], Batch], blocks: Sequence[Run], size: int, seed: int) -> None:
        self._make = make
        self._blocks, self._generator = list(blocks), torch.Generator().manual_seed(seed)
        total = sum(end - first for first, end in blocks)
        self._count = max(1, round(total / size))
        self._batches: list[Batch] = []

    def at(self, step: int) -> Batch:
        """The batch of a step, counted from 0."""
        place = step % self._count
        if place == 0 and (self._count > 1 or not self._batches):
            order = torch.randperm(len(self._blocks), generator=self._generator).tolist()
            parts = [order[part :: self._count] for part in range(self._count)]
            self._batches = [self._make([self._blocks[number] for number in part]) for part in parts]
        return self._batches[place]
