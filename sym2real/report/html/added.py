"""What happens when it is added? The ladder on held-out logs, measured against predicted, the equations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sym2real.diagnosis import Floor
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.report.html.arrays import Arrays
from sym2real.report.html.charts import Chart, Line, of_model
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Figures, Table
from sym2real.report.html.signals import signal_units
from sym2real.report.tables import number
from sym2real.trajectory import Array

# Values of curves in a page, all combinations together: 4 bytes of text each before they are compressed.
MOST_VALUES = 2_000_000


def curves(observed: Observed, arrays: Arrays, *, switched: bool) -> Figures:
    """Every signal of a log, measured and predicted in pieces of 0.8 s."""
    values = sum(predicted.size for _, predicted in observed.curves)
    every = -(-values // MOST_VALUES)
    for index, (log, (measured, predicted)) in enumerate(zip(observed.starts.data, observed.curves, strict=True)):
        rows = _kept(predicted, every)
        arrays.add(f"time/{index}", log.time[rows] - log.time[0])
        arrays.add(f"measured/{index}", measured[rows].T)
        limited = [clipped(predicted[:, rows, place], measured[:, place]) for place in range(measured.shape[1])]
        arrays.add(f"predicted/{index}", np.stack(limited, axis=1))
    charts = []
    for place, (name, unit) in enumerate(signal_units(observed.layout).items()):
        lines = [Line("measured", "measured", "measured", place), *of_model("predicted", place, switched=switched)]
        reading = _reading(observed, place, unit, switched)
        charts.append(Chart(name, reading, "time in s", f"{name} in {unit}", "time", lines, kind="time", of_log=True))
    reading = f"Pieces of {JUDGED_AT:g} s, each from a measured start; what leaves a figure is not drawn."
    return Figures("Measured against predicted", charts, reading)


def _reading(observed: Observed, place: int, unit: str, switched: bool) -> str:
    """Root mean square difference over all logs, as the model stands and with all switches."""
    before, after = (
        np.concatenate([predicted[on, :, place] - measured[:, place] for measured, predicted in observed.curves])
        for on in (0, -1)
    )
    sizes = [number(float(np.sqrt(np.nanmean(np.square(curve)))), 2) for curve in (before, after)]
    return f"{' → '.join(sizes) if switched else sizes[0]} {unit} off over all pieces of all logs (root mean square)."


def _kept(predicted: Array, every: int) -> NDArray[np.int64]:
    """Rows of a log that are drawn: every so many, and those at which a piece begins."""
    gap = np.asarray(np.isnan(predicted).all(axis=(0, 2)))
    return np.flatnonzero((np.arange(len(gap)) % every == 0) | gap).astype(np.int64)


def ladder_charts(stages: Sequence[Stage], floor: Sequence[Floor], arrays: Arrays) -> list[Chart]:
    """Held-out error of every stage over the horizon, one chart a channel."""
    horizons, charts = sorted(stages[0].horizons), []
    arrays.add("ladder", np.array(horizons))
    lowest = {at.horizon: at.errors for at in floor}
    for channel, first in stages[0].horizons[horizons[0]].items():
        lines = []
        for place, stage in enumerate(stages):
            errors = [stage.horizons[at][channel] for at in horizons]
            ends = [[getattr(at, end) for at in errors] for end in ("value", "low", "high")]
            names = [f"ladder-{channel}-{place}-{end}" for end in ("value", "low", "high")]
            for name, values in zip(names, ends, strict=True):
                arrays.add(name, np.array(values))
            lines.append(Line(stage.model, place, names[0], low=names[1], high=names[2]))
        if lowest:
            least = [lowest[at][channel][0] if at in lowest and channel in lowest[at] else np.nan for at in horizons]
            lines.append(
                Line("noise and disturbances", "floor", arrays.add(f"ladder-{channel}-floor", np.array(least)))
            )
        before, after = (stage.horizons[horizons[-1]][channel].value for stage in (stages[0], stages[-1]))
        reading = (
            f"{number(before, 2)} → {number(after, 2)} {first.unit} after {horizons[-1]:g} s; bands are 95 % intervals."
        )
        labels = ("horizon in s", f"error in {first.unit}")
        charts.append(Chart(channel, reading, *labels, "ladder", lines, zero=True, points=True))
    return charts


def ladder_rows(stages: Sequence[Stage], held_out: Sequence[str], *, apart: bool) -> Table:
    """The ladder near 0.8 s ahead as a table."""
    horizon = stages[0].nearest(JUDGED_AT)
    channels = stages[0].horizons[horizon]
    columns = ["model", *(f"{name} in {error.unit}" for name, error in channels.items())]
    rows = [[stage.model, *(_with_interval(error) for error in stage.horizons[horizon].values())] for stage in stages]
    logs = f"{len(held_out)} log{'s' * (len(held_out) != 1)}" if held_out else "pieces"
    how = f"{logs} that took no part in any fit" if apart else f"{logs}, each by the fit of the others"
    if held_out and not apart and len(held_out) == 1:
        how = f"{held_out[0]}, by the fit to the rest of it"
    return Table(f"Held-out error {horizon:.3g} s ahead", columns, rows, f"On {how}; 95 % intervals.")


def _with_interval(error: object) -> str:
    value, low, high = (getattr(error, end) for end in ("value", "low", "high"))
    return f"{number(value)} ({number(low, 2)}…{number(high, 2)})"


def clipped(predicted: Array, measured: Array) -> Array:
    """Predictions that stay within one more span of what was measured; others leave the figure.

    Args:
        predicted: ``# (..., rows)``.
        measured: ``# (rows,)``.
    """
    low, high = float(measured.min()), float(measured.max())
    span = max(high - low, 1e-3)
    inside = (predicted > low - span) & (predicted < high + span)
    return np.where(inside, predicted, np.nan)
