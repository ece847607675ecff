"""A log whose columns have names, before it is cut at its gaps, brought to a step and sorted into groups."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from sym2real.errors import DataError, reason
from sym2real.field import Group
from sym2real.layout import Layouts
from sym2real.logs.derived import add_derived
from sym2real.logs.dropouts import CUT, without_dropouts, without_held, without_repeats
from sym2real.logs.even_rows import with_even_stamps
from sym2real.logs.grouping import trajectory, visible
from sym2real.logs.missing import listed, specification
from sym2real.logs.of_model import for_model
from sym2real.logs.resample import REGULAR, gaps, is_regular, resample
from sym2real.logs.sent_between import sent_in_all_rows, with_commands_between
from sym2real.logs.sources import actions_of, along_body, commands_of, sources_of
from sym2real.logs.specification import LogSpec
from sym2real.logs.standard import Standard, own_specification, stamps, standardise, tidy
from sym2real.logs.table import Table
from sym2real.trajectory import Trajectory, usual_interval
from sym2real.vocabulary import POSITION, VOCABULARY

MEASURED = frozenset(column for group, field in VOCABULARY if group == "state" for column in field.columns)
# Steps of the model between two rows; beyond, stamps are hardly in s.
COARSEST = 20
# Rows to a step of the model; an 8 kHz gyro has 400 in 0.05 s, stamps in s that are read as ms a thousand.
FINEST = 500


def _first_stamp(whole: Table, spec: LogSpec) -> float:
    """Time of the file's first row that has one, s."""
    return float(stamps(without_dropouts(whole, [spec.time.column])[0][:1], spec)[0])


@dataclass(frozen=True, eq=False)
class Opened:
    """A log that has been read and named, before it is cut and sorted.

    Args:
        whole, table: as read, and the rows of it that are kept.
        spec: what its columns mean.
        layouts: of the model, without what no log holds.
        standard: the kept rows in standard columns.
        sent: commands of all rows, where they were logged more often than positions.
        dt: s between two rows that are asked for.
        gaps: rows behind one.
        parts: steps of the model from row to row.
    """

    whole: Table
    table: Table
    spec: LogSpec
    layouts: Layouts | None
    standard: Standard
    sent: Standard | None
    dt: float | None
    gaps: list[int]
    parts: int = 1

    @classmethod
    def open(cls, whole: Table, given: LogSpec | None, layouts: Layouts | None, dt: float | None) -> Opened:
        """Name the columns of a log; arguments and errors as of :func:`read_log`."""
        model_layouts = layouts or _own_layouts(whole)
        known = None if model_layouts is None else visible(model_layouts)
        used = for_model(given or own_specification((*whole.columns, *whole.texts)), whole, known)
        whole, repeated = without_repeats(whole, used.time.column)
        rows = len(whole) - used.drop_first - used.drop_last
        if rows < 1:
            raise DataError(
                whole.path, f"more than the {used.drop_first + used.drop_last} rows to drop", f"{len(whole)}"
            )
        if given is None and used.time.column not in (*whole.columns, *whole.texts):
            raise whole.without(used.time.column, "of time stamps", specification(whole.path))
        flown, sent = whole[used.drop_first : used.drop_first + rows], commands_of(used, model_layouts)
        places = tuple(used.columns[name].column for name in POSITION.columns if name in used.columns)
        measured = [name for name in used.sources if name not in {*places, *sent, used.time.column}]
        flown, held = without_held(flown, places, measured)
        table, left_out = without_dropouts(flown, used.sources, used.hold, sent, used.time.column, places=places)
        standard = standardise(table, used)
        notes = [] if given is None else [*standard.notes]
        if dropped := len(whole) - rows:
            notes.append(f"{dropped} of {len(whole)} rows dropped at the ends")
        start = None if given is None else _first_stamp(whole, used)
        standard = standard if start is None else tidy(standard, start)
        every = sent_in_all_rows(flown, used, places, actions_of(model_layouts), start)
        standard = replace(standard, notes=(*notes, *repeated, *held, *left_out))
        step = dt if dt is not None else used.time.dt
        # Where rows are missing, a log is in pieces whether anybody asks for equal steps or not.
        sends = [values for name, values in standard.columns.items() if name in actions_of(model_layouts)]
        whole_runs = used.time.column not in table.columns or (np.diff(table.columns[used.time.column]) >= 0.0).all()
        cuts = [] if step is None and not left_out and whole_runs else gaps(standard.time, step or 0.0, sends).tolist()
        return cls(whole, table, used, known, standard, every, step, cuts)

    def trajectory(self, start: int, stop: int, suffix: str) -> Trajectory:
        """Rows ``start`` to ``stop``; a suffix of the name says that it was cut."""
        log = self.standard.rows(start, stop)
        if suffix:
            note = f"{CUT}: rows {self.table.lines[start]} to {self.table.lines[stop - 1]}"
            log = replace(log, notes=(*log.notes, note))
        log = with_even_stamps(log, MEASURED.union(self.layouts.state if self.layouts else ()))
        log = add_derived(log, self.spec, self.layouts, self.dt)
        known = self.layouts or Layouts.of(log.columns)
        if not known.state.size:
            actual = f"only {listed(self.whole.columns)}; {specification(self.table.path)}"
            raise DataError(self.table.path, "standard state columns", actual)
        if self.dt is not None and not is_regular(log.time, self.dt):
            log = resample(log, self.dt, known, polled=self.table.polled)
        name = self.table.metadata.get("name") or self.table.path.stem
        result = trajectory(self.table, log, known, name + suffix)
        if self.sent is not None:
            result = with_commands_between(result, self.sent, self.parts)
        notes = _own_notes(self.table) + result.notes
        return replace(
            result, raw=self.whole.columns, notes=notes, sources=sources_of(self.spec), along_body=along_body(self.spec)
        )

    @property
    def apart(self) -> float:
        """Usual time between rows in s, zero of a single row.

        Raises:
            DataError: where that is out of all proportion to the step.
        """
        if self.dt is None or len(self.standard.time) < 2:
            return 0.0
        dt, apart = self.dt, usual_interval(np.diff(self.standard.time))
        expected, actual = "", f"rows {apart:.4g} s apart"
        if apart > COARSEST * dt:
            expected, actual = f"rows at most {COARSEST:g} of the model's steps of {dt:g} s apart", f"{apart:.4g} s"
        elif apart * FINEST < dt:
            expected = f"at most {FINEST} rows in one of the model's steps of {dt:g} s"
        if expected:
            expected += " (is the unit of the stamps right?)"
            raise DataError(self.table.path, expected, actual, column=self.spec.time.column or None)
        return apart


def in_step(logs: Sequence[Opened], upsample: bool) -> list[Opened]:
    """The logs with one step, of the slowest where that is slower than what is asked for."""
    slowest = max((log.apart for log in logs), default=0.0)
    slow = not upsample and any(log.dt is not None and slowest > (1.0 + REGULAR) * log.dt for log in logs)
    if not slow:
        return list(logs)
    return [replace(log, dt=slowest, parts=1 if log.dt is None else round(slowest / log.dt)) for log in logs]


def _own_notes(table: Table) -> tuple[str, ...]:
    try:
        notes = json.loads(table.metadata.get("notes") or "[]")
        if not isinstance(notes, list):
            raise TypeError(f"{notes!r:.80}")
        return tuple(str(note) for note in notes)
    except (TypeError, ValueError, RecursionError) as error:
        raise DataError(table.path, "notes in the file's metadata, a JSON list", reason(error)) from None


def _own_layouts(table: Table) -> Layouts | None:
    text = table.metadata.get("layouts")
    try:
        groups = msgspec.json.decode(text, type=dict[Group, list[dict[str, Any]]]) if text else None
        return None if groups is None else Layouts.from_dict(groups)
    except (KeyError, ValueError, RecursionError) as error:
        raise DataError(table.path, "layouts in the file's metadata", reason(error)) from None
