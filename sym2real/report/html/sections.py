"""The sections of a page, each the answer to a question: how good is the model, where does it fail, what is missing?

And what remains that nobody has explained.
"""

from itertools import pairwise

import numpy as np

from sym2real.diagnosis import Comparison, Diagnosis, Finding
from sym2real.diagnosis.data.windows import JUDGED_AT, channel_units, judged
from sym2real.effects import EFFECTS
from sym2real.report import diagnosis as in_words
from sym2real.report.charts import Chart, Line, Role, of_model
from sym2real.report.comparison import comparison_table, floor_table
from sym2real.report.horizons import comparison_charts
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Card, Cards, Errors, Figures, Lines, Part, Section
from sym2real.report.html.sentences import plain, sentence, sentences
from sym2real.report.tables import number
from sym2real.trajectory import Array

# Ends of the classes of excess error, as parts of nearly the largest (its 95 % quantile).
CLASSES = (1 / 8, 1 / 4, 1 / 2)
EXCESS: tuple[Role, ...] = ("excess0", "excess1", "excess2", "excess3")  # of these classes and what is beyond
PLANE = ("x", "y")


def accuracy(comparison: Comparison, observed: Observed) -> Section:
    """Section of a model on its logs.

    Args:
        comparison: of the model that is given.
        observed: the same model, and with switches on.
    """
    shown = int(np.argmin(np.abs(observed.horizons - JUDGED_AT)))
    errors = (comparison.one_step, *comparison.horizons)[shown].errors
    rows = [(name, error.unit, observed.by_horizon[name], error.floor, error.hold) for name, error in errors.items()]
    ahead = f"{observed.horizons[shown]:g} s ahead"
    parts = (
        Errors(f"Error {ahead}", rows, shown),
        Figures("Error over the horizon", comparison_charts(comparison, observed.by_horizon)),
        comparison_table(comparison),
        floor_table(comparison),
    )
    return Section("accuracy", "How good is the model?", parts)


def failing(comparison: Comparison, observed: Observed) -> Section:
    """Section of a model on its logs; arguments as of :func:`accuracy`."""
    parts: list[Part] = []
    if comparison.where:
        parts.append(Lines("", [f"{sentence(where.statement)}." for where in comparison.where]))
    parts.append(Figures("Along a log", _along(comparison, observed)))
    if comparison.worst:
        parts.append(Lines("The worst seconds", [f"{sentence(segment.statement)}." for segment in comparison.worst]))
    return Section("failing", "Where does it fail?", parts)


def _along(comparison: Comparison, observed: Observed) -> list[Chart]:
    """Charts of one log: its path, and errors over time."""
    starts, units = observed.starts, channel_units(observed.layout)
    times = [log.time[starts.row[mine]] - log.time[0] for log, mine in starts.by_log]
    charts = []
    if all(column in observed.layout for column in PLANE):
        charts.append(_path(comparison, observed, times))
    reading = "Each point is the error at the end of a window that starts there; the slider moves the cursor."
    for channel in judged(observed.by_window):
        title = f"{channel} error {observed.ahead:g} s ahead"
        labels = ("start of the window in s", f"error in {units[channel]}")
        lines = of_model([observed.by_window[channel][:, mine] for _, mine in starts.by_log])
        charts.append(Chart(title, reading, *labels, times, lines, kind="time", zero=True))
    return charts


def _path(comparison: Comparison, observed: Observed, times: list[Array]) -> Chart:
    """The path from above in classes of excess error, which switches move."""
    starts = observed.starts
    lowest = np.nan_to_num(comparison.at(observed.ahead).errors["position"].floor)
    excess = np.sqrt(np.maximum(np.square(observed.by_window["position"]) - lowest**2, 0.0))
    ends = [part * float(np.nanquantile(excess[0], 0.95)) for part in CLASSES]
    places = np.where(np.isnan(excess), -1, np.digitize(excess, ends))  # (B, W)
    across, up = ([log.column(column)[starts.row[mine]] for log, mine in starts.by_log] for column in PLANE)
    names = [f"below {number(ends[0], 2)} m"]
    names += [f"{number(low, 2)} to {number(high, 2)} m" for low, high in pairwise(ends)]
    names.append(f"over {number(ends[-1], 2)} m")
    lines = [Line("measured", "measured", up, x=across)]
    for name, role in zip(names, EXCESS, strict=True):
        pairs = zip(starts.by_log, up, strict=True)
        heights = [_in_class(places[:, mine], own_up, len(lines) - 1) for (_, mine), own_up in pairs]
        lines.append(Line(name, role, heights, x=across, switched=True))
    reading = f"The thicker, the larger the position error {observed.ahead:g} s ahead, beyond the sensors' noise."
    return Chart("path from above", reading, "x in m", "y in m", times, lines, kind="path")


def _in_class(places: Array, up: Array, number: int) -> Array:
    """Heights of the points of a class, and of the point behind each so that stretches join ``# (B, W)``."""
    inside = places == number
    inside[:, 1:] |= inside[:, :-1] & (places[:, 1:] >= 0)
    return np.where(inside, up, np.nan)


def missing(diagnosis: Diagnosis) -> Section:
    """Section of what was found."""
    parts: list[Part] = []
    if diagnosis.findings:
        parts.append(Cards([_card(finding) for finding in diagnosis.findings]))
    else:
        parts.append(Lines("", ["No effect was found that the model lacks."]))
    if diagnosis.faults:
        faults = [sentence(plain(line)) for line in in_words.fault_lines(diagnosis.faults)]
        parts.append(Lines("Wrong with the data, and undone where the logs tell how", faults))
    return Section("missing", "What is missing?", parts)


def _card(finding: Finding) -> Card:
    facts = [("removes", f"{100 * finding.share:.0f} % of the squared error beyond noise")]
    if finding.provisional:
        facts.append(("provisional", in_words.TOO_FEW))
    for name, estimate in finding.parameters.items():
        interval = in_words.interval_text(finding, name)
        facts.append((name, f"{estimate.text} ({interval})" if interval else estimate.text))
    about = EFFECTS[finding.effect.partition(":")[0]].summary
    return Card(finding.effect, about, [*facts, *in_words.known_of(finding)], finding.share)


def remaining(comparison: Comparison, diagnosis: Diagnosis | None) -> Section:
    """Section of what nobody has explained, and of what to know about the data.

    Args:
        comparison: of the model that is given.
        diagnosis: its diagnosis, if there is one.
    """
    parts: list[Part] = []
    if diagnosis is not None:
        left = [*in_words.leftover_lines(diagnosis.leftovers), *in_words.proposal_lines(diagnosis.proposal)]
        parts.append(Lines("Left over", sentences(map(plain, [*left, in_words.misfit_line(diagnosis)]))))
    if comparison.residuals is not None and comparison.residuals.lines():
        parts.append(Lines("One step ahead", sentences(comparison.residuals.lines())))
    if comparison.data is not None:
        parts.append(Lines("The data", sentences(comparison.data.lines())))
    remarks = list(dict.fromkeys([*(diagnosis.notes if diagnosis else ()), *comparison.notes]))
    if remarks:
        parts.append(Lines("Remarks", sentences(remarks)))
    if diagnosis is not None and diagnosis.not_tried:
        parts.append(Lines("Not tested", sentences(in_words.lines_by_reason(diagnosis.not_tried))))
    return Section("remaining", "What remains?", parts)
