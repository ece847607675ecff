"""Logs from arrays as the reader makes them of files: cut at gaps, and at equal steps."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from sym2real.logs.dropouts import CUT
from sym2real.logs.even_rows import with_even_stamps
from sym2real.logs.resample import GAP_INTERVALS, REGULAR, gaps, is_regular, resample
from sym2real.logs.standard import Standard
from sym2real.logs.standing import in_motion
from sym2real.trajectory import Array, Trajectory


def equal_steps(log: Trajectory, dt: float | None = None) -> list[Trajectory]:
    """The stretches of a log without gaps in which it moves, at steps of ``dt``; the log itself where it is one.

    Args:
        log: rows at their stamps.
        dt: the model's step in s; that of a slower log is its own, as is that of a log which is faster by more than
            :data:`~sym2real.logs.resample.REGULAR`: that is no jitter, and whoever asks must say so.
    """
    return [piece for flown in in_motion(log) for piece in _without_gaps(flown, dt)]


def _without_gaps(log: Trajectory, dt: float | None) -> list[Trajectory]:
    if len(log) < 2 or log.between is not None:
        return [log]
    step = log.dt if dt is None or min(abs(own - dt) for own in (log.dt, _mean_step(log))) > REGULAR * dt else dt
    cuts = gaps(log.time, step).tolist()
    if not cuts:
        return [resampled(log, step)]
    pieces = []
    for number, (start, stop) in enumerate(pairwise([0, *cuts, len(log)]), 1):
        note = f"{CUT}: rows {start + 1} to {stop}"
        piece = replace(log.rows(start, stop), name=f"{log.name}#{number}", notes=(*log.notes, note))
        pieces.append(resampled(piece, step))
    return pieces


def without_holes(log: Trajectory, dt: float) -> Trajectory:
    """A log of as many rows whose stamps are whole periods of ``dt`` apart, where some are lost or hold no numbers.

    What was commanded in each row stays, and goes on in those that are lost; states go on from what is known around,
    and behind the last known one as it was: a log that ends before its last row would look as if cut short.
    """
    periods = np.maximum(np.ceil(np.diff(log.time) / dt - 0.5), 1.0)
    log = replace(log, time=dt * np.concatenate([[0.0], np.cumsum(periods)]))
    known, end = np.flatnonzero(np.isfinite(log.state).all(axis=1)), len(log) - 1
    if len(known) and known[-1] < end:
        log = replace(log, state=np.vstack([log.state[:end], log.state[known[-1]]]))
        known = np.append(known, end)
    parts = {name: getattr(log, name)[known] for name in ("time", *log.layouts.groups)}
    extra = {name: values[known] for name, values in log.extra.items()}
    made = resampled(replace(log, **parts, extra=extra), dt)
    held = np.searchsorted(log.time, made.time + 0.5 * dt) - 1
    return replace(made, action=log.action[held]).rows(0, len(log))


def _mean_step(log: Trajectory) -> float:
    """Mean time between rows in s, gaps left out: jitter moves the usual one, and lost rows this one."""
    intervals = np.diff(log.time)
    return float(intervals[intervals <= GAP_INTERVALS * log.dt].mean())


def resampled(log: Trajectory, dt: float) -> Trajectory:
    """A log without gaps at steps of ``dt``; itself where it has them."""
    if is_regular(log.time, dt):
        return log
    columns: dict[str, Array] = dict(log.extra)
    columns |= {name: log.column(name) for name in log.layouts.columns}
    standard = with_even_stamps(Standard(log.time, columns, {}, log.notes), log.layouts.state)
    if is_regular(standard.time, dt):
        return replace(log, time=standard.time, notes=standard.notes)
    made = resample(standard, dt, log.layouts)
    groups: dict[str, Any] = {
        group: np.column_stack([np.empty((len(made.time), 0)), *(made.columns[name] for name in layout)])
        for group, layout in log.layouts.groups.items()
    }
    extra = {name: made.columns[name] for name in log.extra}
    return replace(log, time=made.time, extra=extra, notes=made.notes, **groups)
