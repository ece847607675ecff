"""What a chart shows, for pages and files alike: its lines with their numbers, and what to read in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sym2real.trajectory import Array

# How a line looks, by what it is: page.css and style.py have colours, and dashes so that grey is enough.
Role = Literal["measured", "model", "base", "floor", "hold", "mean", "now", "excess0", "excess1", "excess2", "excess3"]
# Numbers # (n,), or by combination of switches # (B, n); of a chart of one log, a list by log of these.
Values = Array | list[Array]


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a chart.

    Args:
        label: in the legend.
        role: what it is, or the number of a line among others that are alike.
        values: vertical ones; not a number in gaps.
        low, high: ends of its interval, laid out the same.
        x: its own horizontal values; those of the chart by default.
        switched: whether it follows the switches; otherwise it shows the first combination, all off.
    """

    label: str
    role: Role | int
    values: Values
    low: Values | None = None
    high: Values | None = None
    x: Values | None = None
    switched: bool = False


def of_model(values: Values) -> list[Line]:
    """The model that is given and, where there are several combinations of switches, what it is with those on."""
    if len(np.atleast_2d(values[0] if isinstance(values, list) else values)) == 1:
        return [Line("model", "base", values)]
    return [Line("model as it stands", "base", values), Line("with the switches", "model", values, switched=True)]


@dataclass(frozen=True, eq=False)
class Chart:
    """One chart.

    Args:
        title: what it shows.
        reading: one line that says how to read it.
        x, y: labels of the axes, with units.
        along: horizontal values; of a path the times of its points.
        lines: what is drawn.
        kind: "line", "time" (its cursor moves with the slider) or "path" (seen from above, both axes one scale).
        zero: whether the vertical axis begins at zero.
        points: whether values are marked.
    """

    title: str
    reading: str
    x: str
    y: str
    along: Values
    lines: Sequence[Line]
    kind: Literal["line", "time", "path"] = "line"
    zero: bool = False
    points: bool = False


def over_horizons(channel: str, unit: str, reading: str, horizons: Array, lines: Sequence[Line]) -> Chart:
    """Errors of a channel over the horizon in s."""
    labels = ("horizon in s", f"error in {unit}")
    return Chart(channel, reading, *labels, horizons, lines, zero=True, points=True)
