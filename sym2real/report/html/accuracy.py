"""How good is the model? Errors over the horizon beside what the sensors' noise makes, "hold" and the mean."""

from __future__ import annotations

import math

import numpy as np

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.html.arrays import Arrays
from sym2real.report.html.charts import Chart, Line, of_model
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Errors, Figures, Part, Section, Table
from sym2real.report.tables import decimals, number

QUESTION = "How good is the model?"


def accuracy(comparison: Comparison, observed: Observed, arrays: Arrays, *, switched: bool) -> Section:
    """Section of a model on its logs.

    Args:
        comparison: of the model that is given.
        observed: the same model, and with switches on.
        arrays: get what the charts draw.
        switched: whether there are switches.
    """
    points = (comparison.one_step, *comparison.horizons)
    shown = int(np.argmin(np.abs(observed.horizons - JUDGED_AT)))
    rows = []
    for channel, values in observed.by_horizon.items():
        if channel in points[0].errors:
            error = points[shown].errors[channel]
            arrays.add(f"errors/{channel}", values)
            rows.append((channel, error.unit, float(values[0, shown]), error.floor, error.hold))
    ahead = f"{observed.horizons[shown]:g} s ahead"
    parts: list[Part] = [
        Errors(f"Error {ahead}", "Root mean square over windows that start every 0.1 s.", rows, shown),
        Figures("Error over the horizon", _charts(comparison, observed, arrays, switched)),
        _table(comparison),
    ]
    return Section("accuracy", QUESTION, parts)


def _charts(comparison: Comparison, observed: Observed, arrays: Arrays, switched: bool) -> list[Chart]:
    points, charts = (comparison.one_step, *comparison.horizons), []
    arrays.add("horizons", observed.horizons)
    for channel, first in points[0].errors.items():
        errors = [point.errors[channel] for point in points]
        beside = np.array([[error.floor, error.hold, error.spread] for error in errors]).T
        arrays.add(f"beside/{channel}", beside)
        lines = of_model(f"errors/{channel}", switched=switched)
        references = (("sensors' noise", "floor"), ("hold", "hold"), ("mean", "mean"))
        lines += [
            Line(label, role, f"beside/{channel}", row)  # type: ignore[arg-type]
            for row, (label, role) in enumerate(references)
            if np.isfinite(beside[row]).any()
        ]
        reading = _reading(channel, errors[-1].value, errors[-1].hold, points[-1].horizon, first.unit)
        labels = ("horizon in s", f"error in {first.unit}")
        charts.append(Chart(f"{channel}", reading, *labels, "horizons", lines, zero=True, points=True))
    return charts


def _reading(channel: str, value: float, hold: float, horizon: float, unit: str) -> str:
    ratio = hold / value if value > 0 else math.inf
    times = f"{ratio:.0f}" if ratio >= 10 else number(ratio, 2)
    than = f"{times} times less than" if value < hold else "no better than"
    return f"{number(value, 2)} {unit} off in {channel} after {horizon:.3g} s, {than} predicting that nothing changes."


def _table(comparison: Comparison) -> Table:
    """Every horizon with the errors of every channel; fit and skill at the last one below a free run."""
    channels = comparison.one_step.errors
    columns = ["horizon in s", *(f"{name} in {error.unit}" for name, error in channels.items()), "skill", "fit in %"]
    rows = []
    for errors in (comparison.one_step, *comparison.horizons, comparison.free_run):
        first = next(iter(errors.errors.values()))
        sizes = [number(error.value) for error in errors.errors.values()]
        rows.append([f"{errors.horizon:.3g}", *sizes, decimals(first.skill, 2), decimals(first.fit, 0)])
    name = next(iter(channels))
    reading = (
        f"Skill of {name} against hold (1 is perfect, 0 no better); fit of {name} against its mean. Last row: free run."
    )
    return Table("Every horizon", columns, rows, reading)
