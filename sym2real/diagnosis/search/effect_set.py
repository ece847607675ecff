"""Effects that explain logs together, their joint fit, and what the set costs."""

from dataclasses import dataclass
from functools import cached_property

from torch import Tensor

from sym2real.diagnosis.estimate.quadratic import Fit
from sym2real.diagnosis.predict.candidate import Candidate


@dataclass(frozen=True, eq=False)
class EffectSet:
    """Effects and their joint fit.

    Args:
        chosen: the effects, in the order in which they came in.
        fit: of all.
        held_out: loss per fold ``# (folds,)``.
        price: the loss of all folds with the effects' charges.
    """

    chosen: tuple[Candidate, ...]
    fit: Fit
    held_out: Tensor
    price: float

    @property
    def candidate(self) -> Candidate:
        """The effect that came in last."""
        return self.chosen[-1]

    @cached_property
    def loss(self) -> float:
        """Held-out loss of all folds."""
        return float(self.held_out.sum())

    @cached_property
    def names(self) -> frozenset[str]:
        """Of the effects."""
        return frozenset(candidate.name for candidate in self.chosen)

    @property
    def smaller(self) -> list[frozenset[str]]:
        """Names of the sets with one effect less."""
        return [self.names - {name} for name in self.names]
