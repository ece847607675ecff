"""Rows at equal steps from rows at the stamps they were measured at."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from sym2real.layout import Layouts
from sym2real.logs import derive
from sym2real.logs.extremes import reversal
from sym2real.logs.parts import ATTITUDES, HEADINGS, STANDARD_COLUMNS
from sym2real.logs.standard import Columns, Standard, attitude_columns, side_by_side
from sym2real.trajectory import Array, Trajectory, usual_interval
from sym2real.vocabulary import VOCABULARY

# Stamps are regular when every interval is within this share of the step: rounding stays far below it.
REGULAR = 0.02
# Share of a step by which a log's own may differ and be the same: as much would be seen as a gain or a speed.
SAME_CLOCK = 1e-3
# One or two missing rows are bridged; a longer interval is a gap, and nothing is made up inside it. Commands that go up
# and down from row to row tell nothing of what was sent in a row that is lost.
GAP_INTERVALS, CHATTERING_INTERVALS, CHATTERS = 3.5, 1.5, -0.9
# Commands of another clock: so many changes tell, most of them about so many rows apart and not by a whole number.
FEWEST_HELD, MOST_HELD, SLOWER, UNEVEN = 20, 0.7, 2.0, 0.05
# Rows of a log over those that a model's step leaves of it, from which it is said what uses all.
THINNED = 1.5

RESAMPLED = "resampled to"  # what a note of it begins with
BRIDGED = "bridged"  # column of ones where a row was lost between two commands that differ: nobody knows what was sent
TURNED = frozenset(column for name in ATTITUDES for column in attitude_columns(name)).union(*HEADINGS)  # of no mean
COMMANDS = frozenset(column for group, field in VOCABULARY if group == "action" for column in field.columns)


def usual_step(logs: Iterable[Array]) -> float:
    """Usual interval in s of logs ``# (intervals,)`` each: of those like the one that the middle one of all is of."""
    intervals = [own for own in logs if len(own)] or [np.empty(0)]
    steps = [usual_interval(own) for own in intervals]
    middle = np.quantile(np.repeat(steps, [max(1, len(own)) for own in intervals]), 0.5, method="higher")
    like = [own for own, step in zip(intervals, steps, strict=True) if not abs(step - middle) > REGULAR * middle]
    return usual_interval(np.concatenate(like))


def is_regular(time: Array, dt: float) -> bool:
    """Whether stamps ``# (rows,)`` are ``dt`` apart: each interval within :data:`REGULAR`, all in the mean exactly.

    In the mean means within :data:`SAME_CLOCK`, of a few rows within what their first and last stamp may be off.
    """
    if not np.all(np.abs(np.diff(time) - dt) <= REGULAR * dt):
        return False
    length = dt * (len(time) - 1)
    return len(time) < 2 or bool(abs(time[-1] - time[0] - length) <= max(SAME_CLOCK * length, 2.0 * REGULAR * dt))


def gaps(time: Array, dt: float, commands: Iterable[Array] = ()) -> NDArray[np.int64]:
    """Positions of the rows that follow a gap: an interval above :data:`GAP_INTERVALS` × the step.

    The step is ``dt`` or the log's own median interval, whichever is longer. Where one of the commands ``# (rows,)``
    chatters, every lost row leaves a gap.
    """
    if len(time) < 2:
        return np.zeros(0, dtype=np.int64)
    intervals = np.diff(time)
    most = CHATTERING_INTERVALS if any(reversal([sent]) < CHATTERS for sent in commands) else GAP_INTERVALS
    return np.flatnonzero(intervals > most * max(dt, float(np.median(intervals)))) + 1


def resample(log: Standard, dt: float, layouts: Layouts, *, polled: bool = True) -> Standard:
    """The log at steps of ``dt`` from its first stamp on.

    Vectors go linearly, attitudes on the great circle, circles by their angle. Commands hold: a row gets the one that
    was in force in the middle of its step, so that jitter of the stamps delays no command by a whole step; of a log at
    another step than ``dt``, or whose even stamps are of another clock, the mean of those in force, but for attitudes.
    Columns outside the vocabulary and the model's ``layouts`` hold their last value. Commands are ``polled`` where rows
    have the last that they know of.
    """
    commands = COMMANDS.union(layouts.action)
    moving = {*STANDARD_COLUMNS, *layouts.state, *layouts.inputs}
    time = log.time
    # The small number keeps the last row where rounding put its stamp just below the grid.
    grid = time[0] + dt * np.arange(int(np.floor((time[-1] - time[0]) / dt + 1e-6)) + 1)
    in_force = np.searchsorted(time, grid + 0.5 * dt, side="left") - 1
    latest = np.searchsorted(time, grid, side="right") - 1
    averaged = frozenset[str]() if _a_row_a_step(time, dt) else commands - TURNED
    columns: Columns = {}
    for name, values in log.columns.items():
        if name in averaged:
            columns[name] = derive.mean_in_force(_since(time, values) if polled else time, values, grid, grid + dt)
        elif name in commands:
            columns[name] = values[in_force]
        else:
            columns[name] = np.interp(grid, time, values) if name in moving else values[latest]
    columns |= _circles(log, grid, commands) | _attitudes(log, grid, commands)
    others = {name: values[latest] for name, values in log.others.items()}
    lost = _lost(log, grid, dt, latest, [values for name, values in log.columns.items() if name in commands])
    others |= {BRIDGED: lost.astype(np.float64)} if lost.any() else {}
    return Standard(grid, columns, others, (*log.notes, _note(time, dt, len(grid))))


def _lost(log: Standard, grid: Array, dt: float, latest: NDArray[np.int64], sent: Sequence[Array]) -> NDArray[np.bool_]:
    """Which rows of a grid are nearest to none of the log's, between two whose commands differ ``# (rows,)``."""
    following = np.minimum(latest + 1, len(log.time) - 1)
    step = max(dt, float(np.median(np.diff(log.time)))) if len(log.time) > 1 else dt
    away = np.minimum(grid - log.time[latest], log.time[following] - grid) > 0.5 * step
    differ = [own[latest] != own[following] for own in sent]
    return np.asarray(away & np.logical_or.reduce([*differ, np.zeros(len(grid), dtype=bool)]))


def is_resampled(log: Trajectory) -> bool:
    """Whether its rows were measured at other stamps."""
    return any(note.startswith(RESAMPLED) for note in log.notes)


def _a_row_a_step(time: Array, dt: float) -> bool:
    """Whether stamps jitter and each command was held for its period; even stamps tell how long it was held."""
    intervals = np.diff(time)
    usual = float(np.median(intervals))
    even = float(np.median(np.abs(intervals - usual))) <= SAME_CLOCK * usual
    return abs(usual - dt) <= REGULAR * dt and not (even and abs(usual_interval(intervals) - dt) > SAME_CLOCK * dt)


def _since(time: Array, values: Array) -> Array:
    """From when on the value of each row is in force ``# (rows,)``.

    A command that a slower clock than the rows' changes, now every n rows and now every n + 1 (n two or more), was sent
    at some time since the row before, halfway in the mean. One that always changes after n rows is sent by who writes
    the rows.
    """
    changes = np.flatnonzero(np.diff(values)) + 1
    held = np.diff(changes)
    near = held[np.abs(held - np.median(held)) <= 1.0] if len(held) else held  # a command may also rest
    if len(near) < max(FEWEST_HELD, MOST_HELD * len(held)):
        return time
    usual = float(near.mean())
    if usual < SLOWER or abs(usual - round(usual)) <= UNEVEN:
        return time
    since = time.copy()
    since[changes] -= 0.5 * (time[changes] - time[changes - 1])
    return since


def _note(time: Array, dt: float, rows: int) -> str:
    intervals = 1e3 * np.diff(time)
    unused = (
        "" if len(time) < THINNED * rows else f" (a model with a step of {np.median(intervals):.4g} ms uses them all)"
    )
    return (
        f"{RESAMPLED} {1e3 * dt:g} ms from stamps {np.median(intervals):.4g} ms apart "
        f"({intervals.min():.4g} to {intervals.max():.4g}), {len(time)} rows became {rows}{unused}: "
        "vectors linearly, attitudes on the great circle, commands held"
    )


def _circles(log: Standard, grid: Array, commands: frozenset[str]) -> Columns:
    columns: Columns = {}
    for names in HEADINGS:
        circle = side_by_side(log.columns, names)
        if circle is not None and not commands & {*names}:
            turned = np.interp(grid, log.time, derive.counted_heading(*circle.T))
            columns |= dict(zip(names, (np.sin(turned), np.cos(turned)), strict=True))
    return columns


def _attitudes(log: Standard, grid: Array, commands: frozenset[str]) -> Columns:
    columns: Columns = {}
    for names in map(attitude_columns, ATTITUDES):
        values = side_by_side(log.columns, names)
        if values is not None and not commands & {*names}:
            on_circle = Slerp(log.time, Rotation.from_quat(values, scalar_first=True))
            turned = on_circle(np.minimum(grid, log.time[-1])).as_quat(scalar_first=True)
            columns |= dict(zip(names, derive.continuous(turned).T, strict=True))
    return columns
