"""Figures of prediction errors: over time, over the horizon down to the floor, and where they are large."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from sym2real.diagnosis import Floor, Where, WindowErrors
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.report.style import MEASURED, MODELS, REFERENCE, SERIES, grid, legend_below, logarithmic, small
from sym2real.trajectory import Array

BINS = 8
MOST_FEATURES, MOST_BESIDE = 6, 3

Models = Mapping[str, WindowErrors]


def over_time_figure(models: Models) -> Figure:
    """Error of every channel at the end of windows, by the time of their start; one column a log.

    Args:
        models: errors by what the model is called, on the same logs.
    """
    first = next(iter(models.values()))
    channels, count = list(first.errors), len(first.names)
    size = (max(5.0, min(18.0, 3.2 * count)), 2.0 * len(channels))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(channels), count, squeeze=False, sharey="row", sharex="col")
    for style, (label, errors) in zip(MODELS, models.items(), strict=False):
        for column in range(count):
            mine = errors.log == column
            for row, channel in enumerate(channels):
                axes[row, column].plot(errors.start[mine], errors.errors[channel][mine], **style, label=label)
    for row, channel in enumerate(channels):
        axes[row, 0].set_ylabel(f"{channel} in {'m' if channel in ('z', 'xy', 'position') else 'rad'}")
    for column, name in enumerate(first.names):
        axes[0, column].set_title(name, parse_math=False)
        axes[-1, column].set_xlabel("time in s")
    small(axes.ravel())
    legend_below(figure)
    ahead = float(np.median(first.end - first.start))
    figure.suptitle(f"prediction error {ahead:.2g} s ahead")
    return figure


def ladder_figure(stages: Sequence[Stage], floor: Sequence[Floor]) -> Figure:
    """Error of every channel over the horizon for every stage with its 95 % band, down to noise and disturbances."""
    horizons = sorted(stages[0].horizons)
    channels = stages[0].horizons[horizons[0]]
    figure, axes = grid(len(channels), len(channels), 3.6, 3.1)
    for axis, (channel, error) in zip(axes, channels.items(), strict=True):
        for colour, stage in zip(SERIES, stages, strict=False):
            errors = [stage.horizons[horizon][channel] for horizon in horizons]
            axis.plot(horizons, [entry.value for entry in errors], "o-", color=colour, label=stage.model)
            low, high = [entry.low for entry in errors], [entry.high for entry in errors]
            axis.fill_between(horizons, low, high, color=colour, alpha=0.15, linewidth=0)
        lowest = [(entry.horizon, entry.errors[channel][0]) for entry in floor if channel in entry.errors]
        if lowest:
            axis.plot(*zip(*lowest, strict=True), "--", color=REFERENCE, label="noise and disturbances")
        axis.set(xlabel="horizon in s", ylabel=f"error in {error.unit}", title=channel)
        logarithmic(axis)
    legend_below(figure)
    figure.suptitle("held-out error, one effect after the other")
    return figure


def where_figure(models: Models, where: Sequence[Where]) -> Figure:
    """Error of a channel over the features that a person would name, in bins of equally many windows.

    The regions of the statements are shaded, each in its own feature and channel; other features show the first
    channel.
    """
    first = next(iter(models.values()))
    by_feature = {region.feature: region for region in where}
    names = [*by_feature, *(name for name in first.features if name not in by_feature)][:MOST_FEATURES]
    figure, axes = grid(len(names), MOST_BESIDE, 3.7, 2.8)
    for axis, name in zip(axes, names, strict=True):
        channel = by_feature[name].channel if name in by_feature else next(iter(first.errors))
        for style, (label, errors) in zip(MODELS, models.items(), strict=False):
            axis.plot(*binned(errors.features[name], errors.errors[channel]), "o", **style, label=label)
        if name in by_feature:
            axis.axvspan(by_feature[name].low, by_feature[name].high, color=MEASURED, alpha=0.12, linewidth=0)
        axis.set(xlabel=f"{name} in {first.units[name]}", ylabel=f"{channel} error", ylim=(0.0, None))
    small(axes)
    legend_below(figure)
    figure.suptitle("where the model fails")
    return figure


def binned(values: Array, errors: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Mean value and root mean square error of at most so many groups of equally many windows, in order."""
    order = np.argsort(values, kind="stable")
    groups = [group for group in np.array_split(order, bins) if len(group)]
    middles = np.array([values[group].mean() for group in groups])
    sizes = np.array([np.sqrt(np.square(errors[group]).mean()) for group in groups])
    return middles, sizes
