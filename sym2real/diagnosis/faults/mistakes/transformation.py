"""What a user does to a log without wishing to: a list of transformations, each with its inverse and its words.

A transformation says what the log holds in place of what is meant: ``undone`` reads it as meant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import atan2, ceil, cos, degrees, sin
from typing import Protocol

import numpy as np
import torch

from sym2real import rotation
from sym2real.dataset import Dataset
from sym2real.logs.pose import attitude, turned
from sym2real.logs.sources import AsRead
from sym2real.logs.wheel_speed import made_anew
from sym2real.trajectory import Trajectory
from sym2real.vocabulary import ATTITUDE, HEADING


class Transformation(Protocol):
    """How a log differs from what is meant."""

    @property
    def name(self) -> str:
        """What the log holds, for a sentence."""

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns and axes of the log."""

    def undone(self, log: Trajectory) -> Trajectory:
        """A log with the mistake as it should be."""


@dataclass(frozen=True)
class Exchanged:
    """Columns that hold others, some with the other sign.

    Args:
        columns: of state or action.
        sources: for each of them the column that it holds.
        signs: and its sign, 1 or -1.
    """

    columns: tuple[str, ...]
    sources: tuple[str, ...]
    signs: tuple[int, ...]

    @property
    def _held(self) -> list[tuple[str, str, int]]:
        """Every column, the one that it holds, and the sign."""
        return list(zip(self.columns, self.sources, self.signs, strict=True))

    @property
    def wrong(self) -> list[tuple[str, str]]:
        """The columns that do not hold what they are called, and what they hold."""
        return [(own, "-" * (sign < 0) + other) for own, other, sign in self._held if (own, sign) != (other, 1)]

    @property
    def name(self) -> str:
        """Which columns are exchanged, and which are reversed."""
        wrong = self.wrong
        if {own for own, _ in wrong} == {"z", "vz"}:
            return "z down (z vz with the other sign)"
        moved = [own for own, other, _ in self._held if own != other]
        if len(wrong) == 1:
            return f"{wrong[0][0]} with the wrong sign"
        if not moved:
            return f"{' '.join(own for own, _ in wrong)} mirrored (with the other sign)"
        exchanges = ", ".join(f"{own} holds {other}" for own, other in wrong)
        what = "heading counted otherwise" if {*moved} == {*HEADING.columns} else f"{' '.join(moved)} swapped"
        return f"{what} ({exchanges})"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns and axes of the log."""
        logged = read.logged(self.columns)
        pairs = [held for held in self._held if held[0] in logged]
        reads = [f"{other} read {read.column(own)}" for own, other, _ in pairs if own != other]
        flips = [read.column(own) for own, other, sign in pairs if sign * read.sign(own) * read.sign(other) < 0]
        if not reads and not flips and {*self.columns} == {*HEADING.columns}:
            sense = self.signs[0] * self.signs[1] * (1.0 if self.columns == self.sources else -1.0)
            return counted_otherwise(read, sense, -sense * self._meant_by_zero)
        if not reads and not flips:
            return f"correct {' '.join(read.columns(self.columns))}, of which {' '.join(self.columns)} are made"
        change = [f"let {', '.join(reads)}"] * bool(reads) + [f"flip {', '.join(flips)}"] * bool(flips)
        change += ["leave the signs as they are"] * (bool(reads) and not flips)
        return f"{' and '.join(change)} in a specification of the log{read.frame if flips else ''}"

    @property
    def _meant_by_zero(self) -> float:
        """The heading in rad that is meant by a logged one of zero, whose cosine is 1."""
        components = {other: sign * (own == HEADING.columns[1]) for own, other, sign in self._held}
        return atan2(*(components[name] for name in HEADING.columns))

    def undone(self, log: Trajectory) -> Trajectory:
        """With every column in its own place."""
        return log.with_columns({other: sign * log.column(own) for own, other, sign in self._held})


def counted_otherwise(read: AsRead, sense: float, zero: float) -> str:
    """What to change where a heading turns the other way (a sense of -1), or counts from elsewhere (rad)."""
    own, zero = read.column(HEADING.columns[0]) if read.sources else "its column", round(zero, 2)
    change = [f"change the sign of yaw: flip {own}"] * (sense < 0.0)
    if zero:
        meant = read.sign(HEADING.columns[0]) * zero
        change.append(f"give {'it' if change else own} a zero of {meant:.2f} rad ({degrees(meant):.0f} in degrees)")
    return f"{' and '.join(change)} in the log's specification"


@dataclass(frozen=True)
class Turned:
    """World vectors, or the attitude, along axes that are turned about the vertical.

    Args:
        field: "position", "velocity", or "attitude" and "heading", which are turned against the other two.
        angle: rad to the left, by which what is logged is turned from what is meant.
    """

    field: str
    angle: float

    @property
    def name(self) -> str:
        """What is turned, by how much."""
        what = "heading" if self.field in ("attitude", "heading") else self.field
        return f"{what} in a turned frame, by {degrees(self.angle):.0f}° about the vertical"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns and axes of the log."""
        side = "right" if self.angle > 0 else "left"
        turn = f"turn it by {abs(degrees(self.angle)):.0f}° to the {side}, seen from above"
        return f"{turn}, where it is logged, so that all sensors share the world's axes"

    def undone(self, log: Trajectory) -> Trajectory:
        """Turned back."""
        angle = -self.angle
        if self.field == "attitude":
            half = torch.tensor([cos(angle / 2), 0.0, 0.0, sin(angle / 2)], dtype=torch.float64)
            turned = rotation.multiply(half, attitude(log)).numpy()
            return log.with_columns(dict(zip(ATTITUDE.columns, turned.T, strict=True)))
        x, y = {"position": ("x", "y"), "velocity": ("vx", "vy"), "heading": ("cos_yaw", "sin_yaw")}[self.field]
        first, other = log.column(x), log.column(y)
        back = cos(angle) * first - sin(angle) * other, sin(angle) * first + cos(angle) * other
        return log.with_columns({x: back[0], y: back[1]})


@dataclass(frozen=True)
class OtherAxes:
    """Vectors along body axes that are meant along the world's, or the other way.

    Args:
        columns: the vector's.
        logged: "body" or "world", the axes that it stands along.
    """

    columns: tuple[str, ...]
    logged: str

    @property
    def name(self) -> str:
        """Which axes."""
        meant = "world" if self.logged == "body" else "body"
        return f"{' '.join(self.columns)} along {self.logged} axes, not {meant}"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns and axes of the log."""
        if self.logged == "body":
            return 'log the velocity along world axes, or say velocity_frame = "body" in a specification of the log'
        return "log the rates of the gyro, or turn them into body axes"

    def undone(self, log: Trajectory) -> Trajectory:
        """Along the axes that are meant."""
        vectors = turned(log, self.columns, to_world=self.logged == "body")
        return log.with_columns(dict(zip(self.columns, vectors.T, strict=False)))


@dataclass(frozen=True)
class Misread:
    """An attitude or a heading that is meant otherwise than it was read.

    Args:
        name: what it is.
        fix: what to change, in the columns of the log.
        undone: a log as it is meant.
    """

    name: str
    fix: Callable[[AsRead], str]
    undone: Callable[[Trajectory], Trajectory]


@dataclass(frozen=True)
class Late:
    """Columns some rows behind all others, of measurements also parts of a row; negative rows are ahead.

    Args:
        what: for a sentence.
        columns: of one sensor, which has one clock, or the commands.
        rows: by how many.
        dt: s.
    """

    what: str
    columns: tuple[str, ...]
    rows: float
    dt: float

    @property
    def name(self) -> str:
        """How late."""
        count, way = abs(self.rows), "late" if self.rows > 0 else "early"
        rows = f"{count:.2g} row{'s' * (count > 1)}"
        return f"{self.what} {rows} {way} ({' '.join(self.columns)} by {1e3 * count * self.dt:.0f} ms)"

    def fix(self, read: AsRead) -> str:
        """What to change, in the columns and axes of the log."""
        way, by = "earlier" if self.rows > 0 else "later", 1e3 * abs(self.rows) * self.dt
        names = " ".join(read.columns(self.columns))
        return f"stamp all columns of a row with one clock, or move {names} {by:.0f} ms {way} when the log is written"

    def undone(self, log: Trajectory) -> Trajectory:
        """With these columns shifted back, between rows along the line from one to the next; the ends are held."""
        rows = np.arange(len(log))
        back = log.with_columns({name: np.interp(rows + self.rows, rows, log.column(name)) for name in self.columns})
        return replace(back, state=log.layouts.state.normalise(torch.as_tensor(back.state)).numpy())

    def known(self, log: Trajectory) -> Trajectory:
        """The rows in which these columns were measured, of a log that has them shifted back; of too few all."""
        lost = ceil(abs(self.rows))
        start, stop = (0, len(log) - lost) if self.rows > 0 else (lost, len(log))
        return log.rows(start, stop) if stop - start > lost else log


def of_all(transformation: Transformation, data: Dataset) -> Dataset:
    """The logs without the mistake."""
    return Dataset(as_meant(transformation, log) for log in data)


def mended(transformation: Transformation, log: Trajectory) -> Trajectory:
    """A log without the mistake, and without the rows of which it leaves nothing."""
    meant = as_meant(transformation, log)
    return transformation.known(meant) if isinstance(transformation, Late) else meant


def as_meant(transformation: Transformation, log: Trajectory) -> Trajectory:
    """A log without the mistake, and without what the reader has made of it."""
    return made_anew(log, log.changed(transformation.undone))
