"""Learners by the name that a user types, with settings that train in seconds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from sym2real.adaptation.fine_tuning import FineTuning
from sym2real.adaptation.residual_search import ResidualSearch
from sym2real.dataset import Transitions
from sym2real.neural import PAPER, Composed, ResidualTraining, TrainingReport, memory_length
from sym2real.neural.composed import Base
from sym2real.protocols import Learner
from sym2real.registry import Registry
from sym2real.symbolic import Equations

FEWEST_ROWS = 100  # that tell how long a memory is


@dataclass(frozen=True)
class Remembering:
    """A :class:`~sym2real.protocols.Learner`: a residual that sees as many past commands as the logs ask for.

    Args:
        training: of the residual; how far back it sees is found anew with every fit.
    """

    training: ResidualTraining

    def fit(self, transitions: Transitions, base: Base, start: Composed | None = None) -> Composed:
        """The base with a residual on top; see :meth:`fit_reported`."""
        return self.fit_reported(transitions, base, start)[0]

    def fit_reported(
        self, transitions: Transitions, base: Base, start: Composed | None = None
    ) -> tuple[Composed, TrainingReport]:
        """The base with a residual on top, and how that came about; a start that sees less or more is left aside."""
        commands = 0
        if isinstance(base, Equations) and len(transitions) >= FEWEST_ROWS:
            commands = memory_length(transitions, base)
        same = start is not None and start.past_rows == (commands, 0)
        return replace(self.training, commands=commands).fit_reported(transitions, base, start if same else None)


@dataclass(frozen=True)
class NoResidual:
    """A :class:`~sym2real.protocols.Learner` that gives back its base."""

    def fit(self, transitions: Transitions, base: Any, start: Any = None) -> Any:
        """The base."""
        return base


# What a learner is made by, from the seed of its first weights and the columns whose sine and cosine it may use.
LEARNERS: Registry[Callable[[int, Sequence[str]], Learner[Any, Any]]] = Registry(
    "learner",
    {
        "residual": lambda seed, _: ResidualTraining(seed=seed),
        "residual-paper": lambda seed, _: ResidualTraining(widths=PAPER, seed=seed),
        "residual-search": lambda _, angles: ResidualSearch(angles=angles),
        "fine-tune": lambda seed, _: FineTuning(seed=seed),
        "none": lambda *_: NoResidual(),
    },
)


def make_learner(
    name: str, seed: int, *, memory: int | Literal["auto"], angles: Sequence[str] = ()
) -> Learner[Any, Any]:
    """The learner of that name.

    Args:
        name: key of :data:`LEARNERS`.
        seed: of its first weights.
        angles: columns whose sine and cosine equations may hold.
        memory: past commands that a network sees; "auto" for as many as the logs ask for.

    Raises:
        UnknownNameError: when there is no such learner.
    """
    learner = LEARNERS[name](seed, angles)
    if not isinstance(learner, ResidualTraining):
        return learner
    return Remembering(learner) if memory == "auto" else replace(learner, commands=memory)
