"""Velocities and rates of joints that are measurements of their own, as by wheels, radio or a tachometer.

Most logs have them by differences, or from an estimator that filters positions: such a velocity says nothing new, and
its errors go on from row to row, or are those of the positions. One that is measured apart has white noise, which the
coordinate's around the row does not explain, and over a stretch of T = N Δt it misses the change of its coordinate by
what the noise of both makes, no less and no more:

    x(t + T) - x(t) - ∫v dt  ~  N(0, 2 σ_x² + (N - ½) σ_v² Δt²)
"""

from collections.abc import Iterable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.integrate import trapezoid

from sym2real.dataset import Dataset
from sym2real.logs.noise import noise_level
from sym2real.trajectory import Array, Trajectory
from sym2real.vocabulary import JOINT_ANGLE, JOINT_DISPLACEMENT, POSITION

PLACING = (POSITION.name, JOINT_DISPLACEMENT.name, JOINT_ANGLE.name)
STRETCH = 25  # steps over which a coordinate and the integral of its rate are compared
# Times that what has the size of a noise may be off it. A central difference seems 1.6 times as noisy in every second
# row as in every row, and misses its coordinate by a third of what is expected.
ALIKE = 1.3
TINY = 1e-300


def measured_rates(data: Dataset) -> tuple[str, ...]:
    """Fields of the state whose columns are rates that were measured apart from a position, or from joints."""
    layout = data.layouts.state
    placed = {column for field in layout.fields if field.name in PLACING for column in field.columns}
    coordinates = {rate: of for of, rate in layout.rates.items() if of in placed}
    logs = [log for log in data if len(log) > 2 * STRETCH]
    return tuple(
        field.name
        for field in layout.fields
        if logs
        and coordinates.keys() >= {*field.columns}
        and _apart([_evidence(log, coordinates[rate], rate) for log in logs for rate in field.columns])
    )


def _apart(evidence: Iterable[tuple[float, ...]]) -> bool:
    return all(1 / ALIKE < np.sqrt(np.mean(ratios)) < ALIKE for ratios in zip(*evidence, strict=True))


def _evidence(log: Trajectory, coordinate: str, rate: str) -> tuple[float, float, float]:
    """Ratios of variances that are one: of the noise in every second row over that in every row, of what the
    coordinate's noise leaves of it over all of it, and of what is missed over a stretch over what is expected.
    """
    place, speed, dt = log.column(coordinate), log.column(rate), log.dt
    of_place, of_speed, of_half = (_variance(values) for values in (place, speed, speed[::2]))
    starts = np.arange(0, len(log) - STRETCH, STRETCH)
    rows = starts[:, None] + np.arange(STRETCH + 1)
    missed = place[starts + STRETCH] - place[starts] - trapezoid(speed[rows], log.time[rows], axis=1)
    expected = 2 * of_place + (STRETCH - 0.5) * of_speed * dt**2
    noise, around = np.diff(speed, n=3)[1:-1], sliding_window_view(np.diff(place, n=3), 3)
    left = np.square(noise - around @ np.linalg.lstsq(around, noise, rcond=None)[0]).sum() / max(noise @ noise, TINY)
    return of_half / of_speed, float(left), float(np.mean(missed**2)) / expected


def _variance(values: Array) -> float:
    return float(noise_level(values[:, None])[0]) ** 2
