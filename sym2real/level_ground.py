"""What level ground makes equal: no place on it is unlike another, nor is any heading.

A free body's equations are the same wherever it is and wherever it faces (equivariance under SE(2)), so a log that is
turned about the vertical, or moved in the plane, is a log of the same robot. Wind, a slope and a magnet's field break
it; these are no part of a robot.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, pi, sqrt

import numpy as np
import torch

from sym2real import rotation
from sym2real.dataset import Dataset, Transitions
from sym2real.field import Field
from sym2real.layout import Layout, Layouts
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import POSITION, known_field

PLACE = POSITION.columns[:2]
# So many and more, a golden angle apart, so that no term with a heading in it can stand for another at all of them.
HEADINGS = 16
GOLDEN_ANGLE = pi * (3.0 - sqrt(5.0))
PIECE = 200  # rows that are turned together


@dataclass(frozen=True)
class Turn:
    """A world turned about its vertical axis, then moved in the plane.

    Args:
        angle: to the left, rad.
        x, y: in m.
    """

    angle: float
    x: float = 0.0
    y: float = 0.0

    def of_log(self, log: Trajectory) -> Trajectory:
        """The log as somebody with another world frame would have written it; references ``ref_…`` too."""
        return log.changed(self._turned)

    def _turned(self, log: Trajectory) -> Trajectory:
        layouts, extra = log.layouts, dict(log.extra)
        wanted = [f"ref_{name}" for name in layouts.state]
        if all(name in extra for name in wanted):
            turned = self.of_rows(np.stack([extra[name] for name in wanted], axis=1), layouts.state)
            extra |= dict(zip(wanted, turned.T, strict=True))
        state, action, inputs = (self.of_rows(getattr(log, group), layout) for group, layout in layouts.groups.items())
        return replace(log, state=state, action=action, inputs=inputs, extra=extra)

    def of_rows(self, rows: Array, layout: Layout) -> Array:
        """Rows ``# (rows, columns)`` seen from the new world; what stands along body axes stays."""
        result, matrix = rows.copy(), _plane(self.angle)
        for field in layout.fields:
            places = layout.indices(field.columns)
            if field.frame != "world":
                continue
            if field.kind == "quaternion":
                half = torch.tensor([np.cos(self.angle / 2), 0.0, 0.0, np.sin(self.angle / 2)], dtype=torch.float64)
                result[:, places] = rotation.multiply(half, torch.as_tensor(rows[:, places])).numpy()
            else:
                level = places[::-1] if field.kind == "circle" else layout.indices(_level(field))
                moved = (self.x, self.y) if level and field.name == POSITION.name else (0.0, 0.0)
                if level:
                    result[:, level] = rows[:, level] @ matrix.T + moved
        return result


def any_heading_alike(layouts: Layouts) -> bool:
    """Whether these are columns of a body that faces somewhere, each of which can be turned about the vertical."""
    fields = [field for layout in layouts.groups.values() for field in layout.fields]
    of_world = [field for field in fields if field.frame == "world"]
    faces = any(field.kind != "vector" for field in layouts.state.fields if field.frame == "world")
    return faces and all(len(_level(field)) in (0, 2) for field in of_world if field.kind == "vector")


def at_many_headings(data: Dataset) -> Transitions:
    """Steps of pieces of logs, each turned by an angle of its own; all pieces several times where they are few."""
    pieces = [piece for log in data for piece in _pieces(log)]
    times = ceil(HEADINGS / len(pieces))
    steps = Dataset(
        replace(Turn(number * GOLDEN_ANGLE).of_log(piece), name=f"{piece.name}, heading {number}")
        for number, piece in enumerate(pieces * times)
    ).transitions()
    # Every other trajectory validates the others: copies of a piece must be on one side.
    again = steps.trajectory // len(pieces)
    return replace(steps, trajectory=steps.trajectory + again * (len(pieces) % 2))


def _pieces(log: Trajectory) -> Iterator[Trajectory]:
    """Parts of about :data:`PIECE` rows; the last row of one is the first of the next, so that no step is lost."""
    edges = np.linspace(0, len(log) - 1, max(1, round(len(log) / PIECE)) + 1).round().astype(int).tolist()
    return (log.rows(first, last + 1) for first, last in pairwise(edges))


def _level(field: Field) -> tuple[str, ...]:
    """Columns of a vector that lie in the plane."""
    return tuple(column for column in known_field(field.columns[0]).columns[:2] if column in field.columns)


def _plane(angle: float) -> Array:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
