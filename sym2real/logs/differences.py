"""Rates that were computed as differences to the row before: the mean between two rows, not the rate at one.

They are half a row late. Equations take that for slowness, a diagnosis for a delay or an arm of the sensor. The slope
at the row is less noisy and on time.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sym2real.dataset import Dataset
from sym2real.logs.derive import SHORTEST, counted_heading, slope
from sym2real.logs.extremes import reversal
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import HEADING

# Of what they miss slopes by: differences miss the positions in a file by rounding alone.
ROUNDING = 0.1


def rates_on_time(data: Dataset) -> Dataset:
    """The logs with slopes in the place of :func:`differences`."""
    rates = differences(data)
    return Dataset(_with_slopes(log, rates) for log in data) if rates else data


def differences(data: Dataset) -> tuple[str, ...]:
    """Columns of velocities and rates that are differences of noisy coordinates in all logs."""
    coordinates = [_coordinates(log) for log in data]
    return tuple(
        rate for rate in coordinates[0] if _are_differences(data, rate, [of_log[rate] for of_log in coordinates])
    )


def _with_slopes(log: Trajectory, rates: Iterable[str]) -> Trajectory:
    if len(log) < 2:
        return log
    state, coordinates = log.state.copy(), _coordinates(log)
    for rate in rates:
        state[:, log.layouts.state.index(rate)] = slope(log.time, coordinates[rate], SHORTEST)
    return replace(log, state=state)


def _coordinates(log: Trajectory) -> dict[str, Array]:
    """Per column of a rate what it is the rate of ``# (rows,)``."""
    layout = log.layouts.state
    coordinates = {rate: log.column(coordinate) for coordinate, rate in layout.rates.items()}
    if layout.has_field(HEADING.name) and "wz" in layout:
        coordinates["wz"] = counted_heading(*(log.column(name) for name in HEADING.columns))
    return coordinates


def _are_differences(data: Dataset, rate: str, coordinates: list[Array]) -> bool:
    """Whether they are in every log of more than a few rows, and noisy on the whole."""
    changing = list[Array]()
    for log, coordinate in zip(data, coordinates, strict=True):
        if len(log) <= SHORTEST + 1:
            continue
        values = log.column(rate)
        missed = np.abs(np.diff(coordinate) / np.diff(log.time) - values[1:]).mean()
        if not missed < ROUNDING * np.abs(values - slope(log.time, coordinate, SHORTEST))[1:].mean():
            return False
        changing.append(values[1:])
    # Noise of the coordinate makes each change reverse the one before; a simulator of Euler's steps has the same
    # differences without it, and there they are the rate.
    return reversal(changing) < 0.0
