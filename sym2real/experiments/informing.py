"""Diagnosis inside the loop: what logs establish goes into the equations, the learner gets what is left.

What is taken: every finding of a diagnosis whose gate passed, which is that predictions of held-out pieces become
better with them. A verdict asks for more, ten independent pieces, which the eight seconds of a first flight do not
have: such findings are provisional, ``CANNOT_TELL``, and taken all the same, because the loop tests them.

When it is taken back: effects always go into the equations that were given, never into those of the round before. So
what the logs of the next round, the old and the new, do not establish any more is gone with that diagnosis. A set
of effects that flew or predicted worse than the best model before it, beyond the interval, is withdrawn by the loop,
and a model whose predictions leave the robot's limits does not fly.
"""

from collections.abc import Callable

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS, diagnose
from sym2real.errors import ShapeError
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations


def informing(
    plant: MujocoPlant | None, on_progress: Callable[[str], None] = lambda _: None
) -> Callable[[Dataset, Equations], Equations]:
    """What :func:`sym2real.adaptation.loop.adapt` takes as ``inform``.

    Args:
        plant: the plain simulator that the equations were learned from, to calibrate them; None without one.
        on_progress: told what the diagnosis is doing.
    """

    def inform(logs: Dataset, base: Equations) -> Equations:
        """The equations with what passes the gate; as they are where that is nothing, or the logs are too short."""
        if all(len(log) <= ROWS for log in logs):
            return base
        try:
            diagnosis = diagnose(base, logs, plant, on_progress=on_progress)
        except ShapeError:  # every episode crashed before a window was complete
            return base
        better = diagnosis.gate.best is not None and diagnosis.gate.passed
        return diagnosis.apply(base) if diagnosis.findings and better else base

    return inform
