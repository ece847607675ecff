"""Velocity from the stamps of consecutive positions."""

import math
from collections import deque

import numpy as np

from sym2real.trajectory import Array

WINDOW = 0.018  # s: over a control period at 50 Hz, jitter of the stamps counts half as much as over one frame
SHORTEST = 0.009  # s, half of that: over less, the jitter of arrivals counts for more than the motion
TOGETHER = 0.001  # s: no camera is that fast; poses that waited arrive so, and only the newest of them is of now
LONGEST = 0.1  # s: over more the mean velocity is no velocity


class Velocity:
    """Difference quotient over about a control period; NaN until it is long enough, and after a gap.

    Args:
        window: s that the quotient goes back.
        shortest: s below which it is no velocity yet.
        longest: s between two positions, over which it is no velocity any more.
    """

    def __init__(self, window: float = WINDOW, shortest: float = SHORTEST, longest: float = LONGEST) -> None:
        self._window, self._shortest, self._longest = window, shortest, longest
        self._seen: deque[tuple[float, Array]] = deque(maxlen=64)
        self._value = np.full(3, math.nan)

    def add(self, stamp: float, position: Array) -> Array:
        """The velocity ``# (3,)`` in m/s with a position ``# (3,)`` in m at a stamp in s.

        A stamp that has been seen changes nothing; one that goes back begins anew.
        """
        if self._seen and stamp == self._seen[-1][0]:
            return self._value
        if self._seen and not stamp > self._seen[-1][0]:
            self._seen.clear()
        if self._seen and stamp - self._seen[-1][0] < TOGETHER:
            self._seen.pop()
        self._seen.append((stamp, position))
        while len(self._seen) > 2 and self._seen[1][0] <= stamp - self._window:
            self._seen.popleft()
        first, start = self._seen[0]
        elapsed = stamp - first
        known = self._shortest <= elapsed <= self._longest
        self._value = (position - start) / elapsed if known else np.full(3, math.nan)
        if elapsed > self._longest:
            self._seen.popleft()
        return self._value
