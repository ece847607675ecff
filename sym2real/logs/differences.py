"""Rates that were computed as differences to the row before: the mean between two rows, not the rate at one.

They are half a row late. Equations take that for slowness, a diagnosis for a delay or an arm of the sensor. The slope
at the row is less noisy and on time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sym2real.logs.derive import SHORTEST, slope
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING

# Of what they miss slopes by: differences miss the positions in a file by rounding alone.
ROUNDING = 0.1


def rates_on_time(log: Trajectory) -> Trajectory:
    """The log with slopes in the place of velocities and rates that are differences of its noisy coordinates."""
    time, layout, state = log.time, log.layouts.state, log.state.copy()
    if len(log) <= SHORTEST:
        return log
    for rate, coordinate in _coordinates(log).items():
        at_rows = slope(time, coordinate, SHORTEST)
        if _is_difference(time, coordinate, log.column(rate), at_rows):
            state[:, layout.index(rate)] = at_rows
    return replace(log, state=state)


def _coordinates(log: Trajectory) -> dict[str, Array]:
    """Per column of a rate what it is the rate of ``# (rows,)``."""
    layout = log.layouts.state
    found = {rate: log.column(coordinate) for coordinate, rate in layout.rates.items()}
    if layout.has_field(HEADING.name) and "wz" in layout:
        sine, cosine = (log.column(name) for name in HEADING.columns)
        found["wz"] = np.unwrap(np.arctan2(sine, cosine))
    return found


def _is_difference(time: Array, values: Array, rate: Array, at_rows: Array) -> bool:
    missed = np.abs(np.diff(values) / np.diff(time) - rate[1:]).mean()
    change = np.diff(rate[1:])
    # Noise of the coordinate makes each change reverse the one before; a simulator of Euler's steps has the same
    # differences without it, and there they are the rate.
    noisy = float(change[1:] @ change[:-1]) < 0.0
    return noisy and bool(missed < ROUNDING * np.abs(rate - at_rows)[1:].mean())
