"""Diagnosis inside the loop: the effects that pass the gate go into the equations, the learner gets what is left.

What counts is that predictions of held-out pieces become better. A verdict asks for more, a test of significance, for
which the few seconds of a first flight do not suffice; the next round's flight tests the effects in any case.
"""

from __future__ import annotations

from collections.abc import Callable

from sym2real.diagnosis import ROWS, diagnose
from sym2real.plants import MujocoPlant
from sym2real.symbolic import Equations
from sym2real.trajectory import Dataset


def informing(
    plant: MujocoPlant | None, on_progress: Callable[[str], None] = lambda _: None
) -> Callable[[Dataset, Equations], Equations]:
    """What :func:`sym2real.adaptation.adapt` takes as ``inform``.

    Args:
        plant: the plain simulator that the equations were learned from, to calibrate them; None without one.
        on_progress: told what the diagnosis is doing.
    """

    def inform(logs: Dataset, base: Equations) -> Equations:
        """The equations with what passes the gate; as they are where that is nothing, or the logs are too short."""
        if all(len(log) <= ROWS for log in logs):
            return base
        found = diagnose(base, logs, plant, on_progress=on_progress)
        better = found.gate.best is not None and found.gate.passed
        return found.apply(base) if found.findings and better else base

    return inform
