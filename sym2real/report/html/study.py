"""The page of an experiment: a chart for every case, and its table."""

from __future__ import annotations

import numpy as np

from sym2real.experiments.study.outcome import Outcome, Panel
from sym2real.report.html.arrays import Arrays
from sym2real.report.html.charts import Chart, Line
from sym2real.report.html.page import Figures, Lines, Page, Part, Section, Table
from sym2real.report.html.pages import ADDED
from sym2real.report.html.remaining import QUESTION as REMAINS


def study_page(outcome: Outcome) -> Page:
    """What an experiment came to."""
    arrays = Arrays()
    charts = [_chart(place, panel, outcome, arrays) for place, panel in enumerate(outcome.panels)]
    parts: list[Part] = [Figures("Every case", charts, "Bands: standard deviation over seeds.")] if charts else []
    parts.append(Table("All figures", outcome.columns, outcome.rows))
    sections = [Section("added", ADDED, parts)]
    if outcome.notes:
        sections.append(Section("remaining", REMAINS, [Lines("", outcome.notes)]))
    cases = f"{len(outcome.panels)} cases" if charts else f"{len(outcome.rows)} rows"
    return Page(outcome.title, f"{cases}, beside what the paper says of them.", sections, arrays=arrays)


def _chart(place: int, panel: Panel, outcome: Outcome, arrays: Arrays) -> Chart:
    """Lines on the union of their horizontal values: gaps where one has none."""
    every = np.unique(np.concatenate([line.x for line in panel.lines.values()]))
    across = arrays.add(f"panel-{place}", every)
    lines = []
    for number, (name, line) in enumerate(panel.lines.items()):
        ends = {"value": line.mean, "low": line.mean - line.spread, "high": line.mean + line.spread}
        keys = [arrays.add(f"panel-{place}-{number}-{end}", _on(every, line.x, values)) for end, values in ends.items()]
        lines.append(Line(name, number, keys[0], low=keys[1], high=keys[2]))
    if panel.level is not None:
        level = arrays.add(f"panel-{place}-level", np.full(len(every), panel.level))
        lines.append(Line("MPPI with MuJoCo itself", "floor", level))
    reading = f"The paper: {panel.paper}" if panel.paper else ""
    return Chart(panel.title, reading, outcome.x, outcome.y, across, lines, zero=True, points=True)


def _on(every: np.ndarray, x: np.ndarray, values: np.ndarray) -> np.ndarray:
    found = np.full(len(every), np.nan)
    found[np.searchsorted(every, x)] = values
    return found
