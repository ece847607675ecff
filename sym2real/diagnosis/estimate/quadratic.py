"""What is fitted, and the quadratic model about it: losses and derivatives of every segment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor

Free = tuple[int, ...]  # slots of a library

RIDGE = 1e-9
# Far above the smallest normal number, also after the ridge: below it 0/0 is no zero.
LEAST_SCALE = 1e-200
ROUNDS = 2  # of the projected Newton method, per unknown


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


def solve(matrix: Tensor, vector: Tensor) -> Tensor:
    """Solutions with a hair of ridge, so that directions without weight stay put ``# (..., A, A), (..., A)``.

    A robot of which nothing is found and nothing is free has no unknown, and so none to solve for.
    """
    if vector.shape[-1] == 0:
        return vector
    scale = matrix.diagonal(dim1=-2, dim2=-1).clamp_min(LEAST_SCALE)
    ridge = torch.diag_embed(RIDGE * scale + 1e-12 * scale.amax(-1, keepdim=True))
    result: Tensor = torch.linalg.solve(matrix + ridge, vector)
    return result


def solve_within(matrix: Tensor, vector: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """Minima of xᵀAx/2 - bᵀx within bounds ``# (..., A, A), (..., A), (A,), (A,)``.

    The projected Newton method: what a bound holds back stays there, the others go towards where they are best beside
    it, cut at their bounds, and half as far where that is no lower, until nothing changes (D. Bertsekas, SIAM J.
    Control Optim. 20 (1982) 221–246). To cut all unknowns once is no minimum: a lag at its bound hid the inertia beside
    it.
    """
    found = solve(matrix, vector)
    if bool(((low <= found) & (found <= high)).all()):
        return found
    best, goal, part = torch.zeros_like(found).clamp(low, high), found, torch.ones_like(found)
    least = torch.full_like(found[..., :1], torch.inf)
    for _ in range(ROUNDS * vector.shape[-1]):
        found = (best + part * (goal - best)).clamp(low, high)
        if torch.allclose(found, best, rtol=RIDGE, atol=0.0) and bool(least.isfinite().all()):
            break
        pull = vector - (matrix @ found[..., None])[..., 0]
        value = -0.5 * (found * (vector + pull)).sum(-1, keepdim=True)
        lower = value < least
        held = ((found <= low) & (pull < 0.0)) | ((found >= high) & (pull > 0.0))
        ends, free = torch.where(held, found, 0.0), (~held).to(matrix)
        beside = torch.where(held, 0.0, vector - (matrix @ ends[..., None])[..., 0])
        inner = matrix * free[..., None] * free[..., None, :] + torch.diag_embed(1.0 - free)
        least, best = torch.where(lower, value, least), torch.where(lower, found, best)
        goal, part = torch.where(lower, solve(inner, beside) + ends, goal), torch.where(lower, 1.0, part / 2)
    return best


def inverse_of(matrix: Tensor) -> Tensor:
    """Pseudoinverse of a symmetric matrix ``# (..., A, A)``."""
    result: Tensor = torch.linalg.pinv(matrix, hermitian=True)
    return result
