"""Rows in which a sensor or a link gave nothing, or nothing new: they are left out, and it is said where."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sym2real.errors import DataError
from sym2real.logs.derive import in_force
from sym2real.logs.missing import listed
from sym2real.logs.table import Table
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import WHOLE_TURNS

# A column is slower than the others where so much of its numbers stand alone: no log is cut down to their rows.
ALONE = 0.5
NAMED = 3  # stretches of rows that a note lists
# Rows between new positions from which on these are a slower sensor's, how many steps tell, and what part of them must.
SLOWEST, FEWEST_STEPS, MOSTLY = 3, 10, 0.9
LEFT_OUT, CUT = "rows left out", "cut at a gap of the stamps"
UNWRAPPED = f"is unwrapped: it jumps {WHOLE_TURNS}"


def is_unasked(note: str) -> bool:
    """Whether a trajectory's note says that rows are missing from it, or were changed though nobody asked."""
    return LEFT_OUT in note or note.startswith(CUT) or WHOLE_TURNS in note


def lost_in_reading(logs: Iterable[Trajectory]) -> list[str]:
    """What is missing from logs, or was changed though nobody asked; cuts are one line."""
    notes = [(log.name, note) for log in logs for note in log.notes if is_unasked(note)]
    # What names logs itself is of other logs than the one that carries it.
    whole = [(name, note) for name, note in notes if not note.startswith(CUT)]
    lines = [note if note.startswith(f"{LEFT_OUT}:") else f"{name}: {note}" for name, note in whole]
    cut = [f"{name}{note.removeprefix(CUT).replace(':', '')}" for name, note in notes if note.startswith(CUT)]
    return [*lines, *([f"{CUT}: {listed(cut)}"] if cut else [])]


def is_slow(values: Array) -> bool:
    """Whether numbers of a column ``# (rows,)`` mostly stand between empty cells, as those of a slower sensor do."""
    there = ~np.isnan(values)
    return bool(there.any() and (there[:-1] & ~there[1:]).sum() >= ALONE * there.sum())


def without_held(table: Table, places: Sequence[str], others: Collection[str] = ()) -> tuple[Table, tuple[str, ...]]:
    """Positions that a logger repeats until the next one comes as empty cells behind each, and a note on them.

    As those of a satellite receiver in the rows of a faster controller: all of them change together, in every n-th row;
    in every second row only where all else that is measured stands with them.

    Args:
        table: as read.
        places: columns of positions.
        others: of what else is measured.
    """
    values = [table.columns[name] for name in places if name in table.columns]
    if len(values) < 2 or np.isnan(values).any():
        return table, ()
    changes = np.diff(values, axis=1) != 0.0
    rows, together = np.flatnonzero(changes.any(0)) + 1, changes.all(0).sum()
    steps = np.diff(rows)
    often = float(np.median(steps)) if len(steps) >= FEWEST_STEPS else 0.0
    stands = ~changes.any(0)
    beside = [np.diff(table.columns[name])[stands] == 0.0 for name in others if name in table.columns and stands.any()]
    slowest = 2 if beside and np.mean(beside) > MOSTLY else SLOWEST
    off = 1.0 if often >= SLOWEST else 0.0  # a step more or less is half of two
    if often < slowest or min(together / len(rows), np.mean(np.abs(steps - often) <= off)) < MOSTLY:
        return table, ()
    new = np.isin(np.arange(len(table)), [0, *rows])
    held = {name: np.where(new, table.columns[name], np.nan) for name in places if name in table.columns}
    return table.with_columns(held), (f"{', '.join(held)} are new in every {often:g} rows, and stand between",)


def without_dropouts(
    table: Table,
    columns: Sequence[str],
    hold: Sequence[str] = (),
    sent: Collection[str] = (),
    stamp: str = "",
    *,
    places: Collection[str] = (),
) -> tuple[Table, tuple[str, ...]]:
    """The rows in which all of these columns hold a number, and a note on the others.

    Args:
        table: as read.
        columns: of the log; those that it has not are not looked at.
        hold: those whose last number stands until the next one.
        sent: those of commands; of rows of their own, what is in force halfway to the next row that is kept.
        stamp: of stamps, in order.
        places: those of positions: the rows are theirs, as a position that stands is none.

    Raises:
        DataError: for a column that is slower than the others, or when no row is left.
    """
    there = [name for name in dict.fromkeys(columns) if name in table.columns]
    last = {name: last_number(table.columns[name]) for name in there if name in hold and name not in places}
    table = table.with_columns(last)
    empty = {name: np.isnan(table.columns[name]) for name in there}
    if slow := [name for name in there if name not in places and is_slow(table.columns[name])]:
        name, missing = slow[0], empty[slow[0]]
        raise table.error(
            f'numbers in row after row (hold = ["{name}"] in a log specification keeps the last number)',
            f"an empty cell or NaN in {100 * missing.mean():.0f} % of the rows, here first",
            int(missing.argmax()),
            name,
        )
    gone = np.logical_or.reduce([*empty.values(), np.zeros(len(table), dtype=bool)])
    if gone.all():
        empty_throughout = [name for name, missing in empty.items() if missing.all()]
        raise DataError(table.path, f"a row with numbers in all of {', '.join(empty_throughout or there)}", "none")
    if not gone.any():
        return table, ()
    rows = table[~gone]
    commands = {name: values for name, values in last.items() if name in sent}
    if commands and stamp in table.columns and (np.diff(table.columns[stamp]) >= 0.0).all():
        place = in_force(table.columns[stamp], rows.columns[stamp])
        rows = replace(rows.with_columns({name: values[place] for name, values in commands.items()}), polled=False)
    where = _stretches(table.lines[gone])
    names = ", ".join(name for name, missing in empty.items() if missing.any())
    note = f"{gone.sum()} of {len(table)} {LEFT_OUT}, for want of numbers in {names}: rows {where}"
    return rows, (note,)


def without_repeats(table: Table, stamp: str) -> tuple[Table, tuple[str, ...]]:
    """The rows without those that repeat the row before in every column, stamp and all; and a note on them.

    A link that sends twice, or a recorder that writes twice, makes them. Without stamps they are measurements.

    Args:
        table: as read.
        stamp: column of time stamps; "" for none.
    """
    if stamp not in table.columns:
        return table, ()
    values = np.stack([*table.columns.values()])
    repeats = np.zeros(len(table), dtype=bool)
    repeats[1:] = ((values[:, 1:] == values[:, :-1]) | (np.isnan(values[:, 1:]) & np.isnan(values[:, :-1]))).all(0)
    repeats &= ~np.isnan(table.columns[stamp])
    if not repeats.any():
        return table, ()
    where = _stretches(table.lines[repeats])
    note = f"{repeats.sum()} of {len(table)} {LEFT_OUT}, which repeat the one before, stamp and all: rows {where}"
    return table[~repeats], (note,)


def last_number(values: Array) -> Array:
    """Values ``# (rows,)`` with the last number in place of every NaN after one."""
    row = np.where(np.isnan(values), 0, np.arange(len(values)))
    return values[np.maximum.accumulate(row)]


def _stretches(lines: NDArray[np.int64]) -> str:
    """Runs of line numbers in words."""
    runs = np.split(lines, np.flatnonzero(np.diff(lines) > 1) + 1)
    ranges = [f"{run[0]}" if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs]
    more = f" and {len(ranges) - NAMED} other places" if len(ranges) > NAMED else ""
    return ", ".join(ranges[:NAMED]) + more
