"""Who adapts: a frozen base, what is learned on top of it, and whether effects go into the base first."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from sym2real.adaptation.training import Inform
from sym2real.dataset import Dataset
from sym2real.diagnosis import try_effect
from sym2real.experiments.informing import informing as diagnosing
from sym2real.plants import MujocoPlant
from sym2real.registry import Registry
from sym2real.robots import Robot
from sym2real.symbolic import Equations

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

# A diagnosis is asked again when the logs have doubled, and no more beyond so many.
MOST_LOGS = 4


def informing(
    contestant: Contestant, robot: Robot, truth: Sequence[str], tell: Callable[[str], None] = lambda _: None
) -> Inform | None:
    """What a contestant puts into its base; None for one that puts nothing there.

    Args:
        contestant: says whether that is what the logs establish, or the truth.
        robot: whose plain simulator calibrates the base.
        truth: keys of the effects that explain the target.
        tell: takes a line about what the diagnosis does.
    """
    if contestant.effects == "none":
        return None
    if contestant.effects == "true":
        return WhenDoubled(_true(robot, truth))
    return WhenDoubled(diagnosing(MujocoPlant(robot), lambda what: tell(f"diagnosis: {what}")))


class WhenDoubled:
    """An inform that is asked again when the logs have doubled, up to :data:`MOST_LOGS`; between, its answer stays.

    Args:
        inform: asked with all logs.
    """

    def __init__(self, inform: Inform) -> None:
        self.inform = inform
        self._asked = 0
        self._answer: Equations | None = None

    def __call__(self, data: Dataset, base: Equations) -> Equations:
        """The base with effects in it."""
        if self._answer is None or (len(data) >= 2 * self._asked and len(data) <= MOST_LOGS):
            self._asked, self._answer = len(data), self.inform(data, base)
        return self._answer


def _true(robot: Robot, truth: Sequence[str]) -> Inform:
    """The target's own effects, one after the other fitted to the logs."""
    plain = MujocoPlant(robot)

    def inform(data: Dataset, base: Equations) -> Equations:
        for key in truth:
            base = try_effect(base, key, data, plain).apply(base)
        return base

    return inform
