"""What happens when it is added? Measured against predicted."""

import numpy as np
from numpy.typing import NDArray

from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.charts import Chart, Line, of_model
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Figures
from sym2real.report.html.signals import signal_units
from sym2real.report.tables import number
from sym2real.trajectory import Array

# Values of curves in a page, all combinations together: 4 bytes of text each before they are compressed.
MOST_VALUES = 2_000_000


def curves(observed: Observed) -> Figures:
    """Every signal of a log, measured and predicted in pieces of 0.8 s."""
    every = -(-sum(predicted.size for _, predicted in observed.curves) // MOST_VALUES)
    drawn = [_rows_drawn(predicted, every) for _, predicted in observed.curves]
    times = [log.time[rows] - log.time[0] for log, rows in zip(observed.starts.data, drawn, strict=True)]
    charts = []
    for place, (name, unit) in enumerate(signal_units(observed.layout).items()):
        signal = [(measured[:, place], predicted[..., place]) for measured, predicted in observed.curves]
        rows = [(*pair, kept) for pair, kept in zip(signal, drawn, strict=True)]
        lines = [
            Line("measured", "measured", [measured[kept] for measured, _, kept in rows]),
            *of_model([clipped(predicted[:, kept], measured) for measured, predicted, kept in rows]),
        ]
        away = np.concatenate([predicted - measured for measured, predicted in signal], axis=1)  # (B, rows)
        ends = away[[0, -1]] if len(away) > 1 else away
        sizes = [number(float(size), 2) for size in np.sqrt(np.nanmean(ends**2, axis=1))]
        reading = f"{' → '.join(sizes)} {unit} off over all pieces of all logs (root mean square)."
        charts.append(Chart(name, reading, "time in s", f"{name} in {unit}", times, lines, kind="time"))
    reading = f"Pieces of {JUDGED_AT:g} s, each from a measured start; what leaves a figure is not drawn."
    return Figures("Measured against predicted", charts, reading)


def _rows_drawn(predicted: Array, every: int) -> NDArray[np.bool_]:
    """Which rows of a log are drawn ``# (rows,)``: every so many, and those at which a piece begins."""
    drawn = np.asarray(np.isnan(predicted).all(axis=(0, 2)))
    drawn[::every] = True
    return drawn


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
