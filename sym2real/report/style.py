"""One style for all figures as files: colours that every eye tells apart (Okabe and Ito), dashes, legends below."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from sym2real.files import whole

MEASURED, PREDICTED, INFORMED, REFERENCE = "#1a1d21", "#d55e00", "#0072b2", "#7a8390"
SERIES = (PREDICTED, INFORMED, "#009e73", "#b58900", "#cc79a7", "#56b4e9", "#5f6670", "#7a3e00", MEASURED)
# Of a chart's lines, by what they are.
LOOKS: dict[str, dict[str, Any]] = {
    "measured": {"color": MEASURED, "linewidth": 1.0},
    "base": {"color": PREDICTED, "linestyle": "--"},
    "model": {"color": INFORMED},
    "hold": {"color": REFERENCE, "linestyle": "--", "marker": "s"},
    "mean": {"color": REFERENCE, "linestyle": "-.", "marker": ""},
    "floor": {"color": MEASURED, "linestyle": ":", "marker": ""},
}
MOST_BESIDE = 5  # names in a line of a legend
FEW_TICKS, DPI = 4, 120


class Plain(LogFormatter):
    """Where a logarithmic axis has room for a number, the number as people write it: 0.12, no power of ten."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The label of a tick."""
        return f"{x:g}" if super().__call__(x, pos) else ""


def logarithmic(axis: Axes) -> None:
    """Make the vertical axis logarithmic."""
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(Plain())
    axis.yaxis.set_minor_formatter(Plain(labelOnlyBase=False, minor_thresholds=(1, 0.4)))


def legend_below(figure: Figure) -> None:
    """One legend for all axes, outside of them, so that it covers no data."""
    pairs = [pair for axis in figure.axes for pair in zip(*axis.get_legend_handles_labels(), strict=True)]
    shown = {label: handle for handle, label in reversed(pairs)}  # the first of a name stays
    columns = max(1, min(len(shown), MOST_BESIDE, int(figure.get_figwidth() // 1.6)))
    figure.legend([*shown.values()][::-1], [*shown][::-1], loc="outside lower center", ncols=columns, frameon=False)


def grid(count: int, beside: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure of so many axes, each of that size in inches, at most so many beside each other."""
    across = min(beside, count)
    down = -(-count // across)
    figure = Figure(figsize=(max(5.0, width * across), height * down + 0.5), layout="constrained")
    axes = figure.subplots(down, across, squeeze=False).ravel().tolist()
    for unused in axes[count:]:
        unused.set_visible(False)
    return figure, axes[:count]


def small(axes: Iterable[Axes]) -> None:
    """Few ticks, and titles that stand still: what small axes have room for, laid out in two thirds of the time."""
    for axis in axes:
        axis.locator_params(nbins=FEW_TICKS)
        axis.set_title(axis.get_title(), y=1.0)


def save(figure: Figure, folder: Path, name: str) -> Path:
    """Write a figure into a folder, as matplotlib's ``savefig.format`` says: PNG by default."""
    path = folder / f"{name}.{rcParams['savefig.format']}"
    with whole(path) as beside:
        figure.savefig(beside, dpi=DPI)
    return path
