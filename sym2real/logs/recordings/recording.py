"""A recording of several sources, each at stamps of its own, and the table that they make together.

Rows are the stamps of the fastest measured topic that is asked for. What another topic *measured* is interpolated on
the line between the messages on both sides; what it *commanded* is held from its message on, as the robot holds it: a
row gets what is in force halfway to the next row, which a controller that answers the row has sent by then, or, of a
topic that is faster than the rows, the mean until the next row; angles, which have none, are in force.
Where a topic is silent for longer than :data:`SILENCE` of its periods, its measurements are NaN: nothing is made up.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from sym2real.logs.assignment import assign
from sym2real.logs.derive import in_force, mean_in_force
from sym2real.logs.names import read_name
from sym2real.trajectory import Array
from sym2real.vocabulary import EULER_ANGLES

TIME = "t"  # name of the column of stamps, s since the first message
# Up to so many periods between messages are a short hole, as between rows of a file (docs/specification.md).
SILENCE = 3.5
FASTER = 1.5  # times as many commands as rows, of which a row has several
ROUNDING = 0.1  # rad; headings are logged up to a full turn, and a little more after rounding


@dataclass(frozen=True)
class ColumnKinds:
    """What is known of columns beyond what their names say.

    Args:
        sent: by column, whether it holds commands.
        angles: columns of angles, which may jump by whole turns.
        quaternions: the four columns of each.
    """

    sent: Mapping[str, bool] = field(default_factory=dict)
    angles: Collection[str] = ()
    quaternions: Collection[tuple[str, ...]] = ()

    def is_command(self, column: str) -> bool:
        """Whether it was sent or wanted, not measured."""
        named = read_name(column)
        return self.sent.get(column, named is not None and named.role != "state")


BY_NAMES = ColumnKinds()


@dataclass(frozen=True, eq=False)
class Topic:
    """What one source sent.

    Args:
        name: of the source.
        stamps: s, of one clock for all topics ``# (messages,)``.
        columns: by their names in the table, ``topic.field``, each ``# (messages,)``.
    """

    name: str
    stamps: Array
    columns: Mapping[str, Array]

    def in_order(self) -> Topic:
        """The messages by their stamps; of several with one stamp the last."""
        order = np.argsort(self.stamps, kind="stable")
        stamps = self.stamps[order]
        last = np.append(np.diff(stamps) > 0, True)
        columns = {name: values[order][last] for name, values in self.columns.items()}
        return Topic(self.name, stamps[last], columns)

    @property
    def rate(self) -> float:
        """Messages per second."""
        lasts = self.stamps[-1] - self.stamps[0]
        return float((len(self.stamps) - 1) / lasts) if lasts > 0 else 0.0


Recording = tuple[Topic, ...]  # of one file, each with a message at least


def put_together(
    recording: Recording, wanted: Collection[str] | None = None, kinds: ColumnKinds = BY_NAMES
) -> dict[str, Array]:
    """Columns ``# (rows,)`` of the topics that hold one of the wanted columns, and :data:`TIME`.

    Args:
        recording: topics.
        wanted: names of columns; None for those whose names say that they belong to a robot's log. Where no topic
            holds one, all topics are taken.
        kinds: of columns, where their names do not say so.
    """
    asked = set(_recognised(recording) if wanted is None else wanted)
    used = [topic.in_order() for topic in recording if asked & topic.columns.keys()]
    used = used or [topic.in_order() for topic in recording]
    rows = max(used, key=lambda topic: (not all(map(kinds.is_command, topic.columns)), topic.rate))
    start = min(topic.stamps[0] for topic in used)
    table = {TIME: rows.stamps - start, **rows.columns}
    for topic in used:
        if topic is not rows:
            table |= _at(topic, rows.stamps, kinds)
    return table


def _recognised(recording: Recording) -> list[str]:
    sorted_out = assign([name for topic in recording for name in topic.columns])
    parts = [*sorted_out.quaternions.values(), *sorted_out.angles.values(), sorted_out.columns]
    return [column for part in parts for column in part.values()]


def _at(topic: Topic, stamps: Array, kinds: ColumnKinds) -> dict[str, Array]:
    """A topic's columns at other stamps ``# (rows,)``."""
    before = in_force(topic.stamps, stamps)
    begun = before >= 0
    held = {
        name: np.where(begun, values[np.maximum(before, 0)], np.nan)
        for name, values in topic.columns.items()
        if kinds.is_command(name)
    }
    if len(stamps) > 1 and topic.rate * float(np.median(np.diff(stamps))) >= FASTER:
        known = {name: topic.columns[name] for name in held if not _turns(name, kinds)}
        whole = {name: values for name, values in known.items() if not np.isnan(values).any()}
        steps = np.diff(stamps)
        ends = stamps + np.minimum(np.append(steps, np.inf), np.median(steps))  # not of a gap
        means = {name: mean_in_force(topic.stamps, values, stamps, ends) for name, values in whole.items()}
        held |= {name: np.where(begun, mean, np.nan) for name, mean in means.items()}
    heard = _heard(topic.stamps, stamps)
    measured = _without_jumps({name: values for name, values in topic.columns.items() if name not in held}, kinds)
    return held | {
        name: np.where(heard, np.interp(stamps, topic.stamps, values), np.nan) for name, values in measured.items()
    }


def _turns(name: str, kinds: ColumnKinds) -> bool:
    """Whether a column is of an attitude or an angle that may go round."""
    named = read_name(name)
    known = name in kinds.angles or any(name in parts for parts in kinds.quaternions)
    return known or (named is not None and named.quantity in (*EULER_ANGLES, "quaternion"))


def _heard(own: Array, stamps: Array) -> Array:
    """Whether each stamp ``# (rows,)`` lies on a message, or between two that are close enough."""
    after = np.searchsorted(own, stamps, side="left").clip(0, len(own) - 1)
    before = (np.searchsorted(own, stamps, side="right") - 1).clip(0, len(own) - 1)
    inside = (own[0] <= stamps) & (stamps <= own[-1])
    period = float(np.median(np.diff(own))) if len(own) > 1 else 0.0
    return np.asarray(inside & (own[after] - own[before] <= SILENCE * period))


def _without_jumps(columns: Mapping[str, Array], kinds: ColumnKinds) -> dict[str, Array]:
    """Angles without full turns and quaternions without changes of sign, so that lines between rows mean something."""
    result = dict(columns)
    quaternions = {str(parts): [*parts] for parts in kinds.quaternions if {*parts} <= columns.keys()}
    known = {part for parts in quaternions.values() for part in parts}
    for name, values in columns.items():
        named = None if name in known else read_name(name)
        if name in kinds.angles or (named is not None and named.quantity in EULER_ANGLES):
            there = ~np.isnan(values)  # past an empty cell NumPy unwraps nothing
            span = values[there].max(initial=-np.inf) - values[there].min(initial=np.inf)
            turn = 2 * np.pi if span <= 2 * np.pi + ROUNDING else 360.0
            # A robot turns by less than a quarter from row to row; small angles in degrees jump by less than the rest.
            result[name] = values.copy()
            result[name][there] = np.unwrap(values[there], discont=0.75 * turn, period=turn)
        elif named is not None and named.quantity == "quaternion":
            quaternions.setdefault(re.sub(r"[^.\[_]*$", "", name.rstrip("]")), []).append(name)
    for parts in quaternions.values():
        if len(parts) == 4:
            whole = np.stack([columns[name] for name in parts], axis=1)
            turns = np.sum(whole[1:] * whole[:-1], axis=1) < 0
            signs = np.concatenate([[1.0], np.where(np.cumsum(turns) % 2, -1.0, 1.0)])
            result |= {name: signs * columns[name] for name in parts}
    return result
