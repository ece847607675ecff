"""Who adapts: a frozen base, what is learned on top of it, and whether effects go into the base first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sym2real.registry import Registry


@dataclass(frozen=True)
class Contestant:
    """One way to adapt; \\* means frozen.

    Args:
        title: as the paper writes it.
        base: equations that Stage I found, or an ensemble of networks.
        residual: what is learned on top: nothing, a network, a network that sees past commands, or equations;
            tuned where the base is not frozen and its own numbers are fitted.
        effects: what goes into the base before: nothing, what the diagnosis establishes from the target's logs, or the
            target's own effects, fitted to them.
        judged: False of one that is shown to compare with: it knows what nobody is told.
    """

    title: str
    base: Literal["sr", "nn"] = "sr"
    residual: Literal["none", "nn", "memory", "sr", "tuned"] = "none"
    effects: Literal["none", "diagnosed", "true"] = "none"
    judged: bool = True


CONTESTANTS = Registry(
    "contestant",
    {
        "sr-nn": Contestant("SR*+NN", residual="nn"),
        "sr-sr": Contestant("SR*+SR", residual="sr"),
        "sr-tuned": Contestant("SR fine-tuned", residual="tuned"),
        "nn-nn": Contestant("NN*+NN", base="nn", residual="nn"),
        "nn-sr": Contestant("NN*+SR", base="nn", residual="sr"),
        "sr-effect": Contestant("SR*+effect", effects="diagnosed"),
        "sr-effect-nn": Contestant("SR*+effect+NN", residual="nn", effects="diagnosed"),
        "sr-true": Contestant("SR*+true effect", effects="true", judged=False),
        "sr-memory": Contestant("SR*+memory NN", residual="memory"),
        "sr-effect-memory": Contestant("SR*+effect+memory NN", residual="memory", effects="diagnosed"),
    },
)
