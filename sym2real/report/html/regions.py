"""Errors against what a person would say of a moment (how fast, how high), with intervals, for every combination."""

from collections.abc import Sequence

import numpy as np

from sym2real.diagnosis import Where
from sym2real.diagnosis.data.conditions import features, over_windows, units_of
from sym2real.diagnosis.data.windows import channel_units
from sym2real.diagnosis.errors.rungs import error_of
from sym2real.report.charts import Chart, of_model
from sym2real.report.html.observed import Observed
from sym2real.report.html.sentences import sentence
from sym2real.report.tables import number
from sym2real.trajectory import Array

BINS, MOST = 8, 6
FEWEST = 4  # windows in a bin: fewer say nothing of a root mean square
BLOCK = 10  # windows that overlap and hang together


def regions(observed: Observed, where: Sequence[Where]) -> list[Chart]:
    """Errors over the features of statements first, then over others with the first channel."""
    known, said = _features(observed), {region.feature: region for region in where}
    names = [*(name for name in said if name in known), *(name for name in known if name not in said)]
    varied = [name for name in names if np.ptp(known[name]) > 0]
    return [_chart(observed, name, known[name], said.get(name)) for name in varied[:MOST]]


def _features(observed: Observed) -> dict[str, Array]:
    """Mean of every feature over the windows that have an error ``# (windows,)``."""
    starts, steps = observed.starts, round(observed.ahead / observed.starts.data.dt)
    by_log = [features(log) for log in starts.data]
    found = {}
    for name in (name for name in units_of(starts.data.layouts.state) if all(name in means for means in by_log)):
        values = np.full(len(starts.row), np.nan)
        for index, means in enumerate(by_log):
            mine = (starts.log == index) & (starts.left >= steps)
            values[mine] = over_windows(means[name], starts.row[mine], steps)
        found[name] = values[observed.judged]
    return found


def _chart(observed: Observed, feature: str, values: Array, where: Where | None) -> Chart:
    """Root mean square errors in bins of equally many windows, with 95 % intervals over blocks of windows."""
    layout, judged = observed.layout, observed.judged
    channel = where.channel if where else next(iter(observed.by_window))
    unit = channel_units(layout).get(channel, "m")
    log = observed.starts.log[judged]
    blocks = np.unique(log * 10_000 + np.arange(len(log)) // BLOCK, return_inverse=True)[1]
    count = max(1, min(BINS, len(values) // FEWEST))
    bins = [np.sort(members) for members in np.array_split(np.argsort(values, kind="stable"), count)]
    errors = [
        [error_of(own[members], blocks[members], unit) for members in bins]
        for own in observed.by_window[channel][:, judged]
    ]
    middle = np.array([values[members].mean() for members in bins])
    value, low, high = np.array([[[at.value, at.low, at.high] for at in own] for own in errors]).transpose(2, 0, 1)
    spread = f"Between {number(value[0].min(), 2)} and {number(value[0].max(), 2)} {unit} over its range."
    reading = f"{sentence(where.statement)}." if where else spread
    title, labels = (
        f"{channel} error against {feature}",
        (f"{feature} in {units_of(layout)[feature]}", f"error in {unit}"),
    )
    return Chart(title, reading, *labels, middle, of_model(value, low, high), zero=True, points=True)
