"""Where does it fail? The path coloured by error beyond noise, errors over time, the worst seconds."""

from itertools import pairwise

import numpy as np

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import channel_units, judged
from sym2real.report.charts import Chart, Line, Role, of_model
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Figures, Lines, Part, Section
from sym2real.report.html.sentences import sentence
from sym2real.report.tables import number
from sym2real.trajectory import Array

QUESTION = "Where does it fail?"
# Ends of the classes of excess error, as parts of nearly the largest (its 95 % quantile).
CLASSES = (1 / 8, 1 / 4, 1 / 2)
EXCESS: tuple[Role, ...] = ("excess0", "excess1", "excess2", "excess3")  # of these classes and what is beyond
PLANE = ("x", "y")


def failing(comparison: Comparison, observed: Observed) -> Section:
    """Section of a model on its logs; arguments as of :func:`~sym2real.report.html.accuracy.accuracy`."""
    parts: list[Part] = []
    if comparison.where:
        parts.append(Lines("", [f"{sentence(where.statement)}." for where in comparison.where]))
    parts.append(Figures("Along a log", _along(comparison, observed)))
    if comparison.worst:
        parts.append(Lines("The worst seconds", [f"{sentence(segment.statement)}." for segment in comparison.worst]))
    return Section("failing", QUESTION, parts)


def _along(comparison: Comparison, observed: Observed) -> list[Chart]:
    """Charts of one log: its path, and errors over time."""
    starts, units = observed.starts, channel_units(observed.layout)
    times = [log.time[starts.row[starts.log == index]] - log.time[0] for index, log in enumerate(starts.data)]
    charts = []
    if all(column in observed.layout for column in PLANE):
        charts.append(_path(comparison, observed, times))
    reading = "Each point is the error at the end of a window that starts there; the slider moves the cursor."
    for channel in judged(observed.by_window):
        title, labels = (
            f"{channel} error {observed.ahead:g} s ahead",
            ("start of the window in s", f"error in {units[channel]}"),
        )
        lines = of_model([observed.by_window[channel][:, starts.log == index] for index in range(len(times))])
        charts.append(Chart(title, reading, *labels, times, lines, kind="time", zero=True))
    return charts


def _path(comparison: Comparison, observed: Observed, times: list[Array]) -> Chart:
    """The path from above in classes of excess error, which switches move."""
    starts = observed.starts
    lowest = np.nan_to_num(comparison.at(observed.ahead).errors["position"].floor)
    excess = np.sqrt(np.maximum(np.square(observed.by_window["position"]) - lowest**2, 0.0))
    ends = [part * float(np.nanquantile(excess[0], 0.95)) for part in CLASSES]
    places = np.where(np.isnan(excess), -1, np.digitize(excess, ends))  # (B, W)
    mine = [starts.log == index for index in range(len(times))]
    across, up = (
        [log.column(column)[starts.row[own]] for log, own in zip(starts.data, mine, strict=True)] for column in PLANE
    )
    names = [f"below {number(ends[0], 2)} m"]
    names += [f"{number(low, 2)} to {number(high, 2)} m" for low, high in pairwise(ends)]
    names.append(f"over {number(ends[-1], 2)} m")
    lines = [Line("measured", "measured", up, x=across)]
    for name, role in zip(names, EXCESS, strict=True):
        heights = [_in_class(places[:, own], own_up, len(lines) - 1) for own, own_up in zip(mine, up, strict=True)]
        lines.append(Line(name, role, heights, x=across, switched=True))
    reading = f"The thicker, the larger the position error {observed.ahead:g} s ahead, beyond the sensors' noise."
    return Chart("path from above", reading, "x in m", "y in m", times, lines, kind="path")


def _in_class(places: Array, up: Array, number: int) -> Array:
    """Heights of the points of a class, and of the point behind each so that stretches join ``# (B, W)``."""
    inside = places == number
    inside[:, 1:] |= inside[:, :-1] & (places[:, 1:] >= 0)
    return np.where(inside, up, np.nan)
