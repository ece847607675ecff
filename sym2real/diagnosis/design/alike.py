"""How much of what one effect does to the residuals of a manoeuvre another one does as well.

An effect changes the whitened residuals by r. Another one with the derivatives J, fitted to that, leaves ‖r - Jθ‖².
Where that is less than 0.04 of ‖r‖² (a correlation of 0.98) the two cannot be distinguished; else they are separable
from that size on where it is what any finding needs. A delay and a lag are the same to first order, so of these J is
the change at the size that is to be expected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from sym2real.diagnosis.estimate.fit import Problems
from sym2real.diagnosis.predict.candidate import Candidate
from sym2real.diagnosis.settings import SETTINGS
from sym2real.least_squares import solve


class Others(NamedTuple):
    """What other effects do of a change of the residuals.

    Args:
        like: those that leave next to nothing of it.
        nearest: the one of all others that leaves least; empty where there is none.
        left: the part of its whitened squares that this one leaves.
    """

    like: tuple[str, ...] = ()
    nearest: str = ""
    left: float = 1.0

    @classmethod
    def of(cls, parts: Mapping[str, float]) -> Others:
        """Of the part that every other effect leaves."""
        order = sorted((part, name) for name, part in parts.items())
        like = tuple(name for part, name in order if part < 1.0 - SETTINGS.inseparable)
        left, nearest = (*order[len(like) :], (1.0, ""))[0]
        return cls(like, nearest, left)


@dataclass(frozen=True, eq=False)
class Changes:
    """What effects that act from zero on do to the residuals of a manoeuvre.

    Args:
        problems: the manoeuvre and its noise.
        columns: change of the residuals by every parameter, per scale ``# (S, R, A)``.
        places: columns of every effect.
    """

    problems: Problems
    columns: Tensor
    places: Mapping[str, list[int]]

    @classmethod
    def of(cls, problems: Problems, smooth: Sequence[Candidate]) -> Changes:
        """Of a robot that lacks nothing."""
        problem, null, scale = problems.problem, problems.library.null, problems.library.scale
        free = [slot for own in smooth for slot in own.free]
        columns = problem.linearised(null[None], [free])[0][..., 1:]
        for own in (own for own in smooth if own.starts):
            slot = own.free[0]
            nothing, expected = problem.residuals(torch.stack([null, own.started(null, float((null + scale)[slot]))]))
            columns[..., free.index(slot)] = expected - nothing
        return cls(problems, columns, {own.name: [free.index(slot) for slot in own.free] for own in smooth})

    def others(self, changes: Tensor, but: str = "") -> tuple[Tensor, list[Others]]:
        """Whitened squares of changes of the residuals ``# (S, R, L)``, and what every effect but one does of each."""
        count = changes.shape[-1]
        products = self.problems.whitening.products(torch.cat([changes, self.columns], dim=-1)).sum(0)
        whole, left = products.diagonal()[:count], dict[str, list[float]]()
        for name in (name for name in self.places if name != but):
            places = [count + place for place in self.places[name]]
            part = products[:count, places]
            explained = (part * solve(products[places][:, places], part.mT).mT).sum(1)
            left[name] = (1.0 - explained / whole.clamp_min(1e-300)).tolist()
        return whole, [Others.of({name: parts[change] for name, parts in left.items()}) for change in range(count)]
