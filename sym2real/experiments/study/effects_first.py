"""Effects that go into a base before anything is learned on top of it: what the logs establish, or the target's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sym2real.adaptation.training import Inform
from sym2real.dataset import Dataset
from sym2real.diagnosis import try_effect
from sym2real.experiments.informing import informing as diagnosing
from sym2real.experiments.study.contestants import Contestant
from sym2real.plants import MujocoPlant
from sym2real.robots import Robot
from sym2real.symbolic import Equations

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
