"""What is fitted, and the quadratic model about it: losses and derivatives of every segment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor

Free = tuple[int, ...]  # slots of a library


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Parameters that are free, and where a fit of them starts.

    Args:
        free: slots.
        values: a whole parameter set ``# (P,)``.
    """

    free: Free
    values: Tensor


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis with its quadratic model per segment, in units of the parameters' scales.

    Args:
        free, values: as of a hypothesis.
        held: nuisance parameters, free within bounds of their own, behind the others.
        loss: whitened squares ``# (S,)``.
        gradient: half its derivative ``# (S, A)``.
        curvature: half its second derivative ``# (S, A, A)``.
    """

    free: Free
    held: Free
    values: Tensor
    loss: Tensor
    gradient: Tensor
    curvature: Tensor

    @classmethod
    def of(cls, free: Free, held: Free, values: Tensor, products: Tensor) -> Fit:
        """From products of residuals and their derivatives with each other ``# (S, 1 + A, 1 + A)``."""
        return cls(free, held, values, products[:, 0, 0], products[:, 1:, 0], products[:, 1:, 1:])

    @property
    def total(self) -> float:
        """Whitened squares of all segments."""
        return float(self.loss.sum())

    @property
    def whole(self) -> Free:
        """All that is free."""
        return (*self.free, *self.held)

    def places(self, slots: Sequence[int]) -> list[int]:
        """Where some of the free parameters stand among all of them."""
        return [self.free.index(slot) for slot in slots]

    def part(self, slots: Sequence[int]) -> Fit:
        """The same with some of the free parameters only, and the nuisance."""
        index = [*self.places(slots), *range(len(self.free), len(self.whole))]
        return replace(
            self, free=tuple(slots), gradient=self.gradient[:, index], curvature=self.curvature[:, index][:, :, index]
        )

    def without(self, slots: Sequence[int], step: Tensor) -> Fit:
        """The same with some of the free parameters moved by a step ``# (len(slots),)`` and no longer free."""
        places = self.places(slots)
        rest = [place for place in range(len(self.whole)) if place not in places]
        gone, across = self.curvature[:, places][:, :, places], self.curvature[:, rest][:, :, places]
        gradient = self.gradient[:, places]
        return replace(
            self,
            free=tuple(slot for slot in self.free if slot not in slots),
            loss=self.loss + 2 * gradient @ step + torch.einsum("a,sab,b->s", step, gone, step),
            gradient=self.gradient[:, rest] + across @ step,
            curvature=self.curvature[:, rest][:, :, rest],
        )

    def after(self, step: Tensor) -> Tensor:
        """Loss of every segment, or fold, by its quadratic model after a step of its own ``# (S, A) -> (S,)``."""
        quadratic = torch.einsum("sa,sab,sb->s", step, self.curvature, step)
        return self.loss + 2 * (self.gradient * step).sum(1) + quadratic

    def of_segments(self, which: Tensor) -> Fit:
        """The same for some segments only."""
        return replace(self, loss=self.loss[which], gradient=self.gradient[which], curvature=self.curvature[which])

    def mixed(self, which: Tensor, other: Fit) -> Fit:
        """The same for some segments ``# (S,)``, another one of the same parameters elsewhere."""

        def own(here: Tensor, there: Tensor) -> Tensor:
            return torch.where(which.reshape(-1, *[1] * (here.dim() - 1)), here, there)

        loss, gradient = own(self.loss, other.loss), own(self.gradient, other.gradient)
        return replace(self, loss=loss, gradient=gradient, curvature=own(self.curvature, other.curvature))
