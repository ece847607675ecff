"""The learner that learns nothing: what the equations lack is left to effects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sym2real.trajectory import Transitions


@dataclass(frozen=True)
class NoResidual:
    """A :class:`~sym2real.protocols.Learner` that gives back its base."""

    def fit(self, transitions: Transitions, base: Any, start: Any = None) -> Any:
        """The base."""
        return base
