"""Rates that were computed as differences to the row before: the mean between two rows, not the rate at one.

They are half a row late. Equations take that for slowness, a diagnosis for a delay or an arm of the sensor. The slope
at the row is less noisy and on time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sym2real.logs import derive
from sym2real.trajectory import Array, Trajectory

# Of what they miss slopes by: differences in a file miss its positions by rounding alone.
ROUNDING = 0.1


def on_time(time: Array, columns: Mapping[str, Array], rates: Mapping[str, str], around: int) -> dict[str, Array]:
    """The columns that are differences of noisy coordinates, as slopes.

    Args:
        time: s ``# (rows,)``.
        columns: by name ``# (rows,)``.
        rates: per coordinate the column of its rate; that of a heading is known.
        around: rows that a slope is taken over.
    """
    moved = {}
    if "sin_yaw" in columns and "cos_yaw" in columns:
        turned = np.unwrap(np.arctan2(columns["sin_yaw"], columns["cos_yaw"]))
        columns, rates = {**columns, "yaw": turned}, {**rates, "yaw": "wz"}
    for coordinate, rate in rates.items():
        if len(time) > around and coordinate in columns and rate in columns:
            slope = derive.slope(time, columns[coordinate], around)
            if _is_difference(time, columns[coordinate], columns[rate], slope):
                moved[rate] = slope
    return moved


def rates_on_time(log: Trajectory) -> Trajectory:
    """The same of a log in memory; see :func:`on_time`."""
    layout = log.layouts.state
    columns = dict(zip(layout.columns, log.state.T, strict=True))
    columns |= on_time(log.time, columns, layout.rates, derive.SHORTEST)
    return replace(log, state=np.stack([columns[name] for name in layout.columns], axis=1))


def _is_difference(time: Array, values: Array, rate: Array, slope: Array) -> bool:
    missed = np.abs(np.diff(values) / np.diff(time) - rate[1:]).mean()
    change = np.diff(rate[1:])
    # Noise of the coordinate makes each change reverse the one before; a simulator of Euler's steps has the same
    # differences without it, and there they are the rate.
    noisy = float(change[1:] @ change[:-1]) < 0.0
    return noisy and bool(missed < ROUNDING * np.abs(rate - slope)[1:].mean())
