"""Errors against what a person would say of a moment (how fast, how high), with intervals, for every combination."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sym2real.diagnosis import Where
from sym2real.diagnosis.data.conditions import features, over_windows, units_of
from sym2real.report.html.observed import Observed
from sym2real.trajectory import Array

BINS, MOST = 8, 6
FEWEST = 4  # windows in a bin: fewer say nothing of a root mean square
RESAMPLES, BLOCK = 200, 10  # of blocks of so many windows, which overlap and hang together


@dataclass(frozen=True, eq=False)
class Region:
    """Errors of a channel over a feature, in bins of equally many windows.

    Args:
        feature, unit, channel: what is shown.
        middle: mean of the feature in each bin ``# (bins,)``.
        value, low, high: root mean square errors with a 95 % interval ``# (B, bins)``.
        statement: what was said of it; "" where nothing was.
    """

    feature: str
    unit: str
    channel: str
    middle: Array
    value: Array
    low: Array
    high: Array
    statement: str = ""


def regions(observed: Observed, where: Sequence[Where]) -> tuple[Region, ...]:
    """The features of statements first, then others with the first channel."""
    judged, by_feature = observed.judged, {region.feature: region for region in where}
    known = {name: values[judged] for name, values in _features(observed).items()}
    names = [*(name for name in by_feature if name in known), *(name for name in known if name not in by_feature)]
    first = next(iter(observed.by_window))
    return tuple(
        _region(
            observed, name, known[name], by_feature.get(name), by_feature[name].channel if name in by_feature else first
        )
        for name in names
        if np.ptp(known[name]) > 0
    )[:MOST]


def _features(observed: Observed) -> dict[str, Array]:
    """Mean of every feature over the windows that have an error; not a number for others ``# (W,)``."""
    starts, steps = observed.starts, round(observed.ahead / observed.starts.data.dt)
    by_log = [features(log) for log in starts.data]
    found = {}
    for name in (name for name in units_of(starts.data.layouts.state) if all(name in means for means in by_log)):
        values = np.full(len(starts.row), np.nan)
        for index, means in enumerate(by_log):
            mine = (starts.log == index) & (starts.left >= steps)
            values[mine] = over_windows(means[name], starts.row[mine], steps)
        found[name] = values
    return found


def _region(observed: Observed, name: str, values: Array, where: Where | None, channel: str) -> Region:
    squares = np.square(observed.by_window[channel][:, observed.judged])
    log = observed.starts.log[observed.judged]
    blocks = np.unique(log * 10_000 + np.arange(len(log)) // BLOCK, return_inverse=True)[1]
    order = np.argsort(values, kind="stable")
    groups = np.array_split(order, max(1, min(BINS, len(order) // FEWEST)))
    ends = [_interval(squares[:, group], blocks[group]) for group in groups]
    value, low, high = (np.stack(part, axis=1) for part in zip(*ends, strict=True))
    middle = np.array([values[group].mean() for group in groups])
    unit = units_of(observed.starts.data.layouts.state)[name]
    return Region(name, unit, channel, middle, value, low, high, where.statement if where else "")


def _interval(squares: Array, blocks: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Root mean square ``# (B,)`` of ``# (B, windows)`` and its 95 % interval from resampled blocks."""
    places = np.unique(blocks, return_inverse=True)[1]
    count = places.max() + 1
    member = np.eye(count)[places]  # (windows, blocks)
    sums, sizes = squares @ member, member.sum(0)
    draws = np.random.default_rng(0).integers(0, count, (RESAMPLES, count))
    resampled = sums[:, draws].sum(-1) / sizes[draws].sum(-1)  # (B, RESAMPLES)
    low, high = np.quantile(np.sqrt(resampled), (0.025, 0.975), axis=1)
    return np.sqrt(squares.mean(1)), low, high
