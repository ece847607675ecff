"""Rows that were measured evenly, and whose stamps jitter.

Who writes a log stamps what arrives: the rows of a motion capture come through a network, its exposures are even. What
moves is smooth in the time at which it was measured. So the stamps stay where what was measured is smoother by them
than by even ones, as of a loop that takes now longer and now shorter, and where nothing tells.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sym2real.logs.noise import FEWEST, MAD_TO_SIGMA
from sym2real.logs.standard import Standard
from sym2real.trajectory import Array, usual_interval

# Rows on both sides from which one is predicted.
SIDES = (-2, -1, 1, 2)
# By how much a column is rougher by the wrong stamps. Noise, which is as rough by both, moves this by a few hundredths.
ROUGHER = 1.1
# Part by which the usual interval may not be the step; rows by which it is known first, and ticks at their end that two
# candidates are apart.
UNSURE, FIRST_ROWS, FINE = 0.03, 256, 0.25


def with_even_stamps(log: Standard, measured: Collection[str]) -> Standard:
    """The log with even stamps where what was measured says that it was evenly.

    Args:
        log: rows at their stamps.
        measured: names of columns that follow the robot's motion.
    """
    even = _even(log.time) if len(log.time) >= FEWEST else None
    if even is None:
        return log
    columns = [log.columns[name] for name in measured if name in log.columns]
    pairs = [(_roughness(log.time, values), _roughness(even, values)) for values in columns]
    ratios = [by_stamps / evenly for by_stamps, evenly in pairs if min(by_stamps, evenly) > 0.0]
    if not ratios or max(ratios) < ROUGHER or min(ratios) * ROUGHER < 1.0:
        return log
    jitter = 1e3 * float(np.std(log.time - even))
    step = 1e3 * usual_interval(np.diff(even))
    note = f"stamps jitter by {jitter:.3g} ms about rows that were measured evenly, {step:.4g} ms apart"
    return replace(log, time=even, notes=(*log.notes, note))


def _even(time: Array) -> Array | None:
    """Stamps of a clock that ticks evenly, some of whose rows are lost; None where there are no such.

    A row is of a later tick than the one before it, whichever stamp says otherwise: one that waited for others, or that
    jitters by half a step. Ticks that increase with the rows and are nearest to the stamps are an isotonic regression.
    """
    from sklearn.isotonic import isotonic_regression  # noqa: PLC0415 — a second to load, for logs whose stamps jitter

    rows, (start, step) = np.arange(len(time)), _clock(time)
    for _ in range(2):
        counts = np.round(isotonic_regression((time - start) / step - rows)) + rows
        start, step = _line(counts, time)
    even = start + step * counts
    return even if np.isfinite(even).all() else None


def _clock(time: Array) -> tuple[float, float]:
    """Start and step of the clock whose ticks stamps lie nearest to, whatever rows are lost: of their periodogram.

    The step is known from few rows to a part of them, from twice as many to half of that.
    """
    step, reach, length = usual_interval(np.diff(time)), UNSURE, min(len(time), FIRST_ROWS)
    while True:
        part = time[:length] - time[0]
        steps = step * (1.0 + np.arange(-reach, reach, FINE / length))
        turns = np.exp(2j * np.pi * part / steps[:, None]).mean(axis=1)
        best = int(np.abs(turns).argmax())
        step, start = float(steps[best]), float(np.angle(turns[best])) / (2 * np.pi) * float(steps[best])
        if length == len(time):
            return time[0] + start, step
        reach, length = 2 * FINE / length, min(len(time), 2 * length)


def _line(counts: Array, time: Array) -> tuple[float, float]:
    """Start and slope of the line through stamps over counts. In closed form: solvers give up on wild stamps."""
    middle, apart = counts.mean(), counts - counts.mean()
    step = float((apart * time).sum() / np.square(apart).sum())
    return float(time.mean() - step * middle), step


def _roughness(time: Array, values: Array) -> float:
    """Deviation of rows ``# (rows,)`` from the cubic through two neighbours on either side, as of white noise."""
    middle: NDArray[np.int64] = np.arange(2, len(time) - 2)
    near = time[middle[:, None] + SIDES] - time[middle, None]
    weights = np.stack([_lagrange(near, place) for place in range(len(SIDES))], axis=1)
    missed = values[middle] - (weights * values[middle[:, None] + SIDES]).sum(axis=1)
    return MAD_TO_SIGMA * float(np.median(np.abs(missed) / np.sqrt(1.0 + np.square(weights).sum(axis=1))))


def _lagrange(near: Array, place: int) -> Array:
    """Weight in the row between of the neighbour at a place, of all at these times from it ``# (rows, neighbours)``."""
    others = np.delete(near, place, axis=1)
    return np.asarray(np.prod(others / (others - near[:, [place]]), axis=1))
