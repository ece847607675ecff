"""From a log's own columns to standard ones: units, signs, frames, attitudes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np

from sym2real.errors import DataError
from sym2real.logs import derive
from sym2real.logs.parts import ATTITUDES, ROWS_A_SECOND, STANDARD_COLUMNS, Attitude, Source, TimeBase
from sym2real.logs.specification import LogSpec, load_spec
from sym2real.logs.table import Table
from sym2real.logs.units import UNITS, factor
from sym2real.trajectory import Array
from sym2real.vocabulary import ATTITUDE, VELOCITY

Columns = dict[str, Array]

QUATERNION = ATTITUDE.columns
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])  # times a quaternion
NORM_TOLERANCE = 0.05
# Half a turn about x leads from north-east-down to z up, and from forward-right-down to forward-left-up.
TURNED_ABOUT_X = frozenset(
    prefix + stem + axis + suffix
    for prefix, (stem, suffix), axis in product(
        ("", "ref_"),
        (("", ""), ("v", ""), ("w", ""), ("q", ""), ("f", ""), ("t", ""), ("w", "_cmd"), ("q", "_cmd")),
        "yz",
    )
) | {"yaw", "ref_yaw", "sin_yaw", "ref_sin_yaw"}
# Steps by which a stamp may come too early because rows came in another order; beyond, the clock has been set.
ANEW = 50.0
# Rows of a run whose clock begins anew in a file, at least; part of the run before by which its start may be off.
FEWEST_OF_A_RUN, NEAR_START = 20, 0.1


@dataclass(frozen=True, eq=False)
class Standard:
    """A log in standard columns.

    Args:
        time: s ``# (rows,)``.
        columns: SI values by standard name ``# (rows,)``.
        others: what no standard column was made of, by the log's own names.
        notes: what was done, one sentence each.
    """

    time: Array
    columns: Columns
    others: Columns
    notes: tuple[str, ...] = ()

    def rows(self, start: int, stop: int) -> Standard:
        """The rows ``start … stop-1``."""
        columns = {name: values[start:stop] for name, values in self.columns.items()}
        others = {name: values[start:stop] for name, values in self.others.items()}
        return Standard(self.time[start:stop], columns, others, self.notes)


def attitude_columns(name: str) -> tuple[str, ...]:
    """The four standard columns of "attitude", "attitude_command" or "reference_attitude"."""
    prefix, suffix = ATTITUDES[name]
    return tuple(f"{prefix}{column}{suffix}" for column in QUATERNION)


def side_by_side(columns: Columns, names: Sequence[str]) -> Array | None:
    """Columns of these names ``# (rows, names)``; None unless all are there."""
    return np.stack([columns[name] for name in names], axis=1) if columns.keys() >= set(names) else None


def own_specification(names: Collection[str]) -> LogSpec:
    """The specification of a file whose columns already have standard names."""
    time = "time" if "time" in names else "t"
    # Text in a standard column is a fault of the file, not a column to leave out.
    columns = {name: Source(name) for name in names if name in STANDARD_COLUMNS and name != time}
    return LogSpec("standard names", time=TimeBase(time), columns=columns)


def with_header(spec: LogSpec | str | Path | None, columns: Sequence[str] = ()) -> LogSpec | None:
    """A specification, loaded where it is named, that names the columns of files without a header if they are given.

    Raises:
        DataError, UnknownNameError: as of :func:`~sym2real.logs.load_spec`.
    """
    known = None if spec is None else load_spec(spec)
    return replace(known or own_specification(columns), header=tuple(columns)) if columns else known


def standardise(table: Table, spec: LogSpec) -> Standard:
    """Standard columns of a table, exactly as the specification says and no more.

    Raises:
        DataError: for a missing column, a cell that is no finite number, stamps that do not increase, or four
            columns that are no unit quaternion.
    """
    missing = [name for name in spec.sources if name not in table.columns and name not in table.texts]
    if len(missing) > 1:
        there = ", ".join([*table.columns, *table.texts])
        raise DataError(table.path, f"columns {', '.join(missing)} (specification {spec.name!r})", f"only {there}")
    time = _time(table, spec)
    columns = {name: _column(table, spec, name, source) for name, source in spec.columns.items()}
    for name in ATTITUDES:
        if getattr(spec, name).sources:
            values = _attitude(table, spec, name, getattr(spec, name))
            columns |= dict(zip(attitude_columns(name), values.T, strict=True))
    if spec.frames == "ned_frd":
        columns = {name: -values if name in TURNED_ABOUT_X else values for name, values in columns.items()}
    _check_quaternions(table, columns)
    for prefix in ("", "ref_"):
        if (yaw := columns.pop(f"{prefix}yaw", None)) is not None:
            columns |= {f"{prefix}sin_yaw": np.sin(yaw), f"{prefix}cos_yaw": np.cos(yaw)}
    notes = [f"columns read as specification {spec.name!r} says"]
    if spec.velocity_frame == "body":
        columns |= _velocity_to_world(table, columns)
        notes.append("velocities turned from body to world axes")
    if spec.flip:
        notes.append(f"signs reversed: {', '.join(spec.flip)}")
    used = set(spec.sources)
    others = {name: v for name, v in table.columns.items() if name not in used and name not in columns}
    return Standard(time, columns, others, tuple(notes))


def tidy(log: Standard, start: float) -> Standard:
    """Attitudes of unit length with continuous signs, and time that counts from ``start``."""
    columns = dict(log.columns)
    for name in ATTITUDES:
        if (values := side_by_side(columns, attitude_columns(name))) is not None:
            unit = derive.continuous(values / np.linalg.norm(values, axis=1, keepdims=True))
            columns |= dict(zip(attitude_columns(name), unit.T, strict=True))
    return Standard(log.time - start, columns, log.others, log.notes)


def stamps(table: Table, spec: LogSpec) -> Array:
    """Stamps of a table in s, as they count there ``# (rows,)``.

    Raises:
        DataError: when there are none, or they do not increase strictly.
    """
    if spec.time.rate is not None:
        if not spec.time.rate:
            raise DataError(table.path, f"time.rate of specification {spec.name!r} to be {ROWS_A_SECOND}", "0")
        return table.lines / spec.time.rate
    raw = unbroken(table.column(spec.time.column, "of time stamps"))
    if len(bad := np.flatnonzero(np.diff(raw) <= 0)):
        before, after = float(raw[bad[0]]), float(raw[bad[0] + 1])
        kind = "the same stamp again, with other values" if before == after else "an earlier stamp"
        steps = np.abs(np.diff(raw))
        anew = before > after and before - after > ANEW * float(np.median(steps[steps > 0]))
        clock = "split the file there if its clock begins anew, or sort the rows if they are of several topics"
        mend = f"{clock if anew else 'sort the rows by it'}, and keep one of each stamp"
        if 2 * np.count_nonzero(steps) < len(steps):
            mend = "most rows repeat a stamp, as numbers with too few digits do: write the stamps with more"
        actual = f"{kind} ({before!r} then {after!r}): {mend}"
        raise table.error("stamps that increase strictly", actual, int(bad[0]) + 1, spec.time.column)
    return raw * UNITS[spec.time.unit][1]


def unbroken(stamps: Array) -> Array:
    """Stamps ``# (rows,)`` of several runs in one file, whose clock begins anew, with gaps as long as runs in between.

    As they are where they go back in another way, as stamps of rows in a wrong order do.
    """
    starts = [0, *(np.flatnonzero(np.diff(stamps) < 0) + 1)]
    runs = np.split(stamps, starts[1:])
    anew = all(run[0] - before[0] <= NEAR_START * (before[-1] - before[0]) for before, run in pairwise(runs))
    if len(runs) == 1 or not anew or min(map(len, runs)) < FEWEST_OF_A_RUN:
        return stamps
    later = [2 * before[-1] - before[0] - run[0] for before, run in pairwise(runs)]
    return np.concatenate([run + by for run, by in zip(runs, np.cumsum([0.0, *later]), strict=True)])


def _time(table: Table, spec: LogSpec) -> Array:
    time = stamps(table, spec)
    if len(bad := np.flatnonzero(np.diff(time) <= 0)):
        expected = f"stamps that still differ in s (unit {spec.time.unit})"
        raise table.error(expected, "two that do not", int(bad[0]) + 1, spec.time.column)
    return time


def _column(table: Table, spec: LogSpec, name: str, source: Source) -> Array:
    values = table.column(source.column, f"for {name!r} (specification {spec.name!r})")
    sign = -1.0 if source.column in spec.flip else 1.0
    scale = sign * source.scale * factor(source.unit, name, spec.mass)
    shifted = values - source.zero if source.zero else values
    return shifted if scale == 1.0 else shifted * scale


def quaternions(values: Array, attitude: Attitude) -> Array:
    """Attitudes w x y z, body→world ``# (rows, 4)`` of the columns ``# (rows, 4, 2 or 3)`` that a log has for them."""
    if attitude.euler:
        quaternion = derive.from_euler(values * UNITS[attitude.unit][1])
    else:
        tilt = [attitude.order.index("x")] * (4 - len(attitude.quaternion))
        whole = np.insert(values, tilt, 0.0, axis=1)
        quaternion = np.roll(whole, 1, axis=1) if attitude.order == "xyzw" else whole
    return quaternion * INVERSE if attitude.direction == "world_to_body" else quaternion


def _attitude(table: Table, spec: LogSpec, name: str, attitude: Attitude) -> Array:
    signs = [-1.0 if column in spec.flip else 1.0 for column in attitude.sources]
    columns = [table.column(column, f"for the {name}") for column in attitude.sources]
    return quaternions(np.stack(columns, axis=1) * signs, attitude)


def _check_quaternions(table: Table, columns: Columns) -> None:
    for name in ATTITUDES:
        values = side_by_side(columns, attitude_columns(name))
        norm = np.ones(0) if values is None else np.linalg.norm(values, axis=1)
        if len(bad := np.flatnonzero(np.abs(norm - 1.0) > NORM_TOLERANCE)):
            expected = f"a unit quaternion in {', '.join(attitude_columns(name))}"
            raise table.error(expected, f"a norm of {norm[bad[0]]:.4g}", int(bad[0]))


def _velocity_to_world(table: Table, columns: Columns) -> Columns:
    missing = [name for name in ("vx", "vy") if name not in columns]
    if missing:
        raise DataError(table.path, "vx and vy in the columns, for velocities in body axes", f"no {missing[0]}")
    rows = len(columns["vx"])
    quaternion = side_by_side(columns, QUATERNION)
    if quaternion is None and "sin_yaw" in columns:
        quaternion = derive.about_vertical(np.arctan2(columns["sin_yaw"], columns["cos_yaw"]))
    if quaternion is None:
        raise DataError(table.path, "an attitude or a yaw that turns body velocities into the world", "neither")
    world = derive.to_world(
        quaternion, np.stack([columns.get(name, np.zeros(rows)) for name in VELOCITY.columns], axis=1)
    )
    return {name: world[:, i] for i, name in enumerate(VELOCITY.columns) if name in columns}
