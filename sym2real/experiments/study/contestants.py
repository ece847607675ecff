"""Who adapts: a frozen base, what is learned on top of it, and whether effects go into the base first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sym2real.registry import Registry

# Past commands that a residual with memory sees: half a second of a car's, a fifth of a quadrotor's.
COMMANDS = 10


@dataclass(frozen=True)
class Contestant:
    """One way to adapt; \\* means frozen.

    Args:
        title: as the paper writes it.
        base: equations that Stage I found, or an ensemble of networks.
        learner: of what is learned on top, or of the base's own numbers: a key of
            :data:`~sym2real.experiments.learners.LEARNERS`.
        commands: past ones that a network sees.
        effects: what goes into the base before: nothing, what the diagnosis establishes from the target's logs, or the
            target's own effects, fitted to them.
        judged: False of one that is shown to compare with: it knows what nobody is told.
    """

    title: str
    base: Literal["sr", "nn"] = "sr"
    learner: str = "none"
    commands: int = 0
    effects: Literal["none", "diagnosed", "true"] = "none"
    judged: bool = True


CONTESTANTS = Registry(
    "contestant",
    {
        "sr-nn": Contestant("SR*+NN", learner="residual"),
        "sr-sr": Contestant("SR*+SR", learner="residual-search"),
        "sr-tuned": Contestant("SR fine-tuned", learner="fine-tune"),
        "nn-nn": Contestant("NN*+NN", base="nn", learner="residual"),
        "nn-sr": Contestant("NN*+SR", base="nn", learner="residual-search"),
        "sr-effect": Contestant("SR*+effect", effects="diagnosed"),
        "sr-effect-nn": Contestant("SR*+effect+NN", learner="residual", effects="diagnosed"),
        "sr-true": Contestant("SR*+true effect", effects="true", judged=False),
        "sr-memory": Contestant("SR*+memory NN", learner="residual", commands=COMMANDS),
        "sr-effect-memory": Contestant(
            "SR*+effect+memory NN", learner="residual", commands=COMMANDS, effects="diagnosed"
        ),
    },
)
