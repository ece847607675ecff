"""The error ladder as a figure: one effect after the other, down to noise and disturbances."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from sym2real.diagnosis import Floor
from sym2real.diagnosis.errors.rungs import Stage
from sym2real.report.style import REFERENCE, SERIES, grid, legend_below, logarithmic


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
