"""Whether a car's measured heading turns as its path does."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.logs.course import between, course, decides, together
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING, POSITION, SPEED_COLUMN


@dataclass(frozen=True)
class Against:
    """A heading that turns against the path.

    Args:
        together: how far its opposite turns with the path, 1 always.
        as_it_stands: the same of the heading itself.
        apart: angle in rad from its opposite to the path; 0 where slip may be all of it.
    """

    together: float
    as_it_stands: float
    apart: float

    def undone(self, log: Trajectory) -> Trajectory:
        """The log with a heading that turns to the left."""
        state, place = log.state.copy(), log.layouts.state.slice("heading")
        heading = self.apart - _heading(log)
        state[:, place] = np.stack([np.sin(heading), np.cos(heading)], axis=1)
        return replace(log, state=state)


def against_the_path(data: Dataset) -> Against | None:
    """The fault where it is beyond doubt; None for straight drives, and for robots without a heading."""
    layout = data.layouts.state
    if not layout.has_field("heading") or not all(name in layout for name in POSITION.columns[:2]):
        return None
    ways, headings = [_course(log) for log in data], [_heading(log) for log in data]
    reversed_ = [-heading for heading in headings]
    stands, turned = together(ways, headings), together(ways, reversed_)
    return Against(turned, stands, between(ways, reversed_)) if decides(turned, stands) else None


def _course(log: Trajectory) -> Array:
    speed = log.column(SPEED_COLUMN) if SPEED_COLUMN in log.layouts.action else None
    x, y = (log.column(name) for name in POSITION.columns[:2])
    return course(log.time, x, y, speed)


def _heading(log: Trajectory) -> Array:
    return np.arctan2(*(log.column(name) for name in HEADING.columns))
