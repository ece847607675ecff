"""What a round of adaptation showed: how well its model flew and predicted a log that it was not trained on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from sym2real.adaptation.paired_gain import Improvement

PATIENCE = 2  # rounds without an improvement: a single one may be bad luck of its trajectory


@dataclass(frozen=True)
class Learned:
    """How the model of a round came about.

    Args:
        rows: that it was trained on.
        seconds: of the training.
        base: digest of the equations or networks below what was trained.
        effects: that the equations have.
        penalty: λ, the weight of the residual's size in the loss; NaN where there is none.
        refused: why what was trained is not used and the model is the best so far; empty where it is used.
    """

    rows: int = 0
    seconds: float = 0.0
    base: str = ""
    effects: tuple[str, ...] = ()
    penalty: float = math.nan
    refused: str = ""


@dataclass(frozen=True, kw_only=True)
class RoundReport:
    """One round: its model was trained on the logs of all rounds before, so its own log is held out to it.

    Args:
        number: counted from 0, the model that was given.
        log: name of the trajectory that was flown, or of the recorded one.
        rows: of that log.
        flown: whether it was flown by the model of this round.
        crashed: whether it ended early.
        error: mean position error over all steps of the episode, NaN without a reference.
        cost: mean running cost of the task over them, NaN without a task.
        one_step: one-step prediction error on this log, relative to how far states move.
        horizon: in s.
        prediction: mean error of the position predicted that far ahead on this log.
        best_before: round whose model was the best before this one; on this log the two are compared.
        best_crashed: whether that round ended early.
        gain: by how much the prediction is better than with that model.
        tracking: by how much the position error is, row by row.
        learned: how its model came about.
        unit: of errors of the position: m, of joints theirs.
    """

    number: int
    log: str
    rows: int
    flown: bool
    crashed: bool
    error: float = math.nan
    cost: float = math.nan
    one_step: float = math.nan
    horizon: float
    prediction: float = math.nan
    best_before: int
    best_crashed: bool = False
    gain: Improvement
    tracking: Improvement
    learned: Learned
    unit: str = "m"

    @property
    def progress(self) -> Improvement:
        """What tells whether another trajectory has helped."""
        return self.tracking if self.flown else self.gain

    @property
    def surely_worse(self) -> bool:
        """Whether its model flew this log worse than the best one before, beyond the interval, or predicted it so.

        A model that flew surely better may predict what it likes: flying is what it is for. One that crashed where the
        best did not flew worse, though no interval says so; where it is the best one that flew again, it did not.
        """
        if self.crashed and not self.best_crashed and not self.learned.refused:
            return True
        return self.tracking.surely_worse or (self.gain.surely_worse and not self.tracking.surely_better)


def best_of(reports: Sequence[RoundReport]) -> int:
    """Number of the round whose model is the best so far.

    A model takes the place of the best one where it flew better beyond the interval, or not worse beyond it and
    predicts a log better that neither was trained on; never where it crashed and the best did not. Where the best
    crashed and it did not, it does unless it predicts worse beyond the interval.
    """
    best = 0
    for report in reports[1:]:
        if _is_better(report, reports[best]):
            best = report.number
    return best


def _is_better(report: RoundReport, best: RoundReport) -> bool:
    if report.crashed != best.crashed:
        return best.crashed and not (report.gain.surely_worse or report.learned.refused)
    tracking = report.tracking
    return tracking.surely_better or (report.gain.value > 0.0 and not tracking.surely_worse)


def settled(reports: Sequence[RoundReport]) -> bool:
    """True when two rounds in a row have brought no improvement beyond its interval.

    What counts is the position error of the episodes where they are flown, that of the predictions where nothing flies.
    A round that a crash or a short log leaves without an answer is none of the two. So is a run that is :func:`lost`.
    """
    newest = reports[-PATIENCE:]
    return lost(reports) or (len(reports) > PATIENCE and all(report.progress.stalled for report in newest))


def lost(reports: Sequence[RoundReport]) -> bool:
    """True when models of two rounds in a row were surely worse than the best one before them.

    What learns cannot represent such a target, as a network without memory a delay: the better it predicts the logs
    that are there, the further it leads away from them.
    """
    return any(all(report.surely_worse for report in pair) for pair in pairwise(reports))
