"""Errors over the horizon as charts, for pages and files: of a model on its logs, and of a ladder."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sym2real.diagnosis import Comparison, Floor
from sym2real.diagnosis.errors.rungs import Rung
from sym2real.report.charts import Chart, Line, Role, of_model, over_horizons
from sym2real.report.tables import number
from sym2real.trajectory import Array

# What errors are held against: label, role, and the field of an error.
BESIDE: tuple[tuple[str, Role, str], ...] = (
    ("sensors' noise", "floor", "floor"),
    ("hold", "hold", "hold"),
    ("mean", "mean", "spread"),
)


def comparison_charts(comparison: Comparison, errors: Mapping[str, Array] | None = None) -> list[Chart]:
    """Errors of every channel beside what the sensors' noise makes, "hold" and the mean.

    Args:
        comparison: of a model.
        errors: of every combination of switches by channel ``# (B, horizons)``; those of the comparison by default.
    """
    points, charts = (comparison.one_step, *comparison.horizons), []
    horizons = np.array([at.horizon for at in points])
    for channel, last in points[-1].errors.items():
        along = [at.errors[channel] for at in points]
        lines = of_model(np.array([error.value for error in along]) if errors is None else errors[channel])
        for label, role, name in BESIDE:
            values = np.array([getattr(error, name) for error in along])
            if np.isfinite(values).any():
                lines.append(Line(label, role, values))
        ratio = last.hold / last.value if last.value > 0 else math.inf
        times = f"{ratio:.0f}" if ratio >= 10 else number(ratio, 2)
        than = f"{times} times less than" if last.value < last.hold else "no better than"
        off = f"{number(last.value, 2)} {last.unit} off in {channel} after {points[-1].horizon:.3g} s"
        reading = f"{off}, {than} predicting that nothing changes."
        charts.append(over_horizons(channel, last.unit, reading, horizons, lines))
    return charts


def ladder_charts(stages: Sequence[Rung], floor: Sequence[Floor]) -> list[Chart]:
    """Held-out error of every channel for every stage with its 95 % band, down to noise and disturbances."""
    horizons, charts = sorted(stages[0].horizons), []
    lowest = {at.horizon: at.errors for at in floor}
    for channel, first in stages[0].horizons[horizons[0]].items():
        lines = []
        for place, stage in enumerate(stages):
            errors = [stage.horizons[at][channel] for at in horizons]
            value, low, high = np.array([[error.value, error.low, error.high] for error in errors]).T
            lines.append(Line(stage.model, place, value, low, high))
        least = np.array([lowest.get(at, {}).get(channel, (np.nan, ""))[0] for at in horizons])
        if np.isfinite(least).any():
            lines.append(Line("noise and disturbances", "floor", least))
        before, after = (number(stage.horizons[horizons[-1]][channel].value, 2) for stage in (stages[0], stages[-1]))
        reading = f"{before} → {after} {first.unit} after {horizons[-1]:g} s; bands are 95 % intervals."
        charts.append(over_horizons(channel, first.unit, reading, np.array(horizons), lines))
    return charts
