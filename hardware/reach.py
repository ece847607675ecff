"""A body seen where it cannot have moved to: another one, or a reflection, mistaken for it."""

import numpy as np

from sym2real.trajectory import Array

FASTEST = 5.0  # m/s: twice what a quadrotor in a room or a car flies or drives
JUMP = 0.05  # m beyond that: poses that waited arrive together, and have moved all the same
AGREEING = 5  # poses in a row: then it was put there, or all before were wrong


class Reach:
    """Which places of a body are to be believed.

    Attributes:
        anew: whether the place that was believed last is out of reach of the one before.
    """

    def __init__(self) -> None:
        self.anew = False
        self._believed: tuple[Array, float] | None = None
        self._doubted: list[tuple[Array, float]] = []

    def holds(self, place: Array, time: float) -> bool:
        """Whether to believe a place ``# (3,)`` in m at a time in s: near the last one, or as several in a row."""
        seen = place, time
        near = self._believed is None or _reached(self._believed, seen)
        if not near:
            agree = bool(self._doubted) and _reached(self._doubted[-1], seen)
            self._doubted = [*self._doubted, seen] if agree else [seen]
            if len(self._doubted) < AGREEING:
                return False
        self._believed, self._doubted, self.anew = seen, [], not near
        return True


def _reached(before: tuple[Array, float], after: tuple[Array, float]) -> bool:
    distance = float(np.linalg.norm(after[0] - before[0]))
    return distance <= FASTEST * max(after[1] - before[1], 0.0) + JUMP
