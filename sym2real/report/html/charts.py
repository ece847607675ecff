"""What a chart shows, for the page's script: which arrays, how they are called, what to read in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

# How a line looks, by what it is: colours are in page.css, dashes beside them so that grey is enough.
Role = Literal["measured", "model", "base", "floor", "hold", "mean", "now", "excess0", "excess1", "excess2", "excess3"]


@dataclass(frozen=True)
class Line:
    """One line of a chart.

    Args:
        label: in the legend.
        role: what it is, or the number of a line among others that are alike.
        array: name of its values; with ``of_log`` that of a family, one for every log.
        row: of the last but one axis.
        switched: whether the first axis is the combination of switches.
        low, high: arrays of the ends of its interval, laid out the same.
        x: array of its own horizontal values; those of the chart by default.
    """

    label: str
    role: Role | int
    array: str
    row: int = 0
    switched: bool = False
    low: str = ""
    high: str = ""
    x: str = ""


def of_model(array: str, row: int = 0, *, switched: bool, low: str = "", high: str = "") -> list[Line]:
    """The model that is given and, where there are switches, what it is with those that are on."""
    if not switched:
        return [Line("model", "base", array, row, low=low, high=high)]
    return [
        Line("model as it stands", "base", array, row, low=low, high=high),
        Line("with the switches", "model", array, row, switched=True, low=low, high=high),
    ]


@dataclass(frozen=True)
class Chart:
    """One chart.

    Args:
        title: what it shows.
        reading: one line that says how to read it.
        x, y: labels of the axes, with units.
        array: horizontal values; of a path the place now, seen by time.
        lines: what is drawn.
        kind: "line", "time" (its cursor moves with the slider) or "path" (seen from above, both axes one scale).
        of_log: whether arrays are families, one for every log.
        zero: whether the vertical axis begins at zero.
        points: whether values are marked.
    """

    title: str
    reading: str
    x: str
    y: str
    array: str
    lines: Sequence[Line]
    kind: Literal["line", "time", "path"] = "line"
    of_log: bool = False
    zero: bool = False
    points: bool = False

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)
