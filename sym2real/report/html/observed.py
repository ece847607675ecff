"""What every combination of switches predicts of the logs: errors over the horizon and of every window, and curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from sym2real.dataset import Dataset
from sym2real.diagnosis import ROWS
from sym2real.diagnosis.data.start import Start
from sym2real.diagnosis.data.windows import channel_units, horizons_in_rows
from sym2real.diagnosis.errors.by_window import HORIZON, named_channels
from sym2real.layout import Layout
from sym2real.report.html.predictions import Starts
from sym2real.report.html.signals import signals, unwrapped
from sym2real.report.html.variants import Given, WithFindings, subsets
from sym2real.trajectory import Array


@dataclass(frozen=True, eq=False)
class Observed:
    """Predictions of all variants, as far as a page shows them; axis B goes over the combinations of switches.

    Args:
        starts: windows, which start every 0.1 s.
        horizons: in s ``# (K,)``.
        ahead: horizon of the errors of windows, in s.
        by_horizon: root mean square error by channel ``# (B, K)``.
        by_window: error by channel; not a number where a log ends before ``# (B, W)``.
        curves: by log, measured signals ``# (rows, signals)`` and predicted ones with gaps ``# (B, rows, signals)``.
        windows: predicted signals of single windows by their place, ``# (B, steps, signals)``.
    """

    starts: Starts
    horizons: Array
    ahead: float
    by_horizon: dict[str, Array]
    by_window: dict[str, Array]
    curves: tuple[tuple[Array, Array], ...]
    windows: dict[int, Array]

    @property
    def layout(self) -> Layout:
        """Of the measured states."""
        return self.starts.data.layouts.state

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Windows that have an error ``# (W,)``."""
        first = next(iter(self.by_window.values()))
        return np.asarray(~np.isnan(first).all(axis=0))


def observe(
    variants: Given | WithFindings, data: Dataset, method: Start = "smoothed", single: Sequence[tuple[int, float]] = ()
) -> Observed:
    """Predict with every combination of switches.

    Args:
        variants: models.
        data: logs with the models' columns.
        method: how start states are estimated.
        single: windows that are wanted whole: log and time of the start, in s from the log's start.
    """
    longest = max(len(step) for step in data) - ROWS
    steps = sorted(
        {step for horizon in horizons_in_rows(data.dt) if 1 <= (step := round(horizon / data.dt)) <= longest} | {1}
    )
    starts, shown = Starts.of(data, steps[-1], method), min(round(HORIZON / data.dt), steps[-1])
    layout, measured = data.layouts.state, starts.measured
    wanted = [_place(starts, log, seconds) for log, seconds in single]
    by_horizon, by_window, curves, windows = [], [], [], []
    for on in subsets(len(variants.switches)):
        predicted = starts.predicted(*variants.prepared(on, data))
        away = layout.difference(predicted, measured)
        by_horizon.append([_sizes(layout, away[:, step - 1]) for step in steps])
        by_window.append(_sizes(layout, away[:, shown - 1]))
        curves.append([signals(layout, states) for states in starts.along(predicted)])
        windows.append(signals(layout, predicted[wanted].numpy()))
    channels = list(by_window[0])
    return Observed(
        starts=starts,
        horizons=np.array(steps) * data.dt,
        ahead=shown * data.dt,
        by_horizon={
            name: np.array([[_rms(errors[name]) for errors in row] for row in by_horizon]) for name in channels
        },
        by_window={name: np.array([row[name] for row in by_window]) for name in channels},
        curves=tuple(
            unwrapped(layout, signals(layout, log.state), np.array([row[index] for row in curves]))
            for index, log in enumerate(data)
        ),
        windows={place: np.array([row[number] for row in windows]) for number, place in enumerate(wanted)},
    )


def _place(starts: Starts, log: int, seconds: float) -> int:
    """The window of a log that starts nearest to a time, in s from the log's start."""
    time = starts.data[log].time - starts.data[log].time[0]
    away = np.where(starts.log == log, np.abs(time[np.minimum(starts.row, len(time) - 1)] - seconds), np.inf)
    return int(np.argmin(away))


def _sizes(layout: Layout, away: Tensor) -> dict[str, Array]:
    """Norms of tangents ``# (W, tangent)`` by channel: those of reports, and the vertical and horizontal position."""
    parts = away.split([field.tangent_size for field in layout.fields], dim=-1)
    sizes: dict[str, Array] = {
        name: part.norm(dim=-1).numpy() for name, part in zip(channel_units(layout), parts, strict=True)
    }
    return sizes | {name: away[:, places].norm(dim=-1).numpy() for name, places in named_channels(layout).items()}


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.nanmean(np.square(errors))))
