"""The page of an adaptation: what another trajectory has brought, and the model before and after it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sym2real.adaptation import RoundReport
from sym2real.dataset import Dataset
from sym2real.report.adaptation import rounds_headings, rounds_rows
from sym2real.report.html.arrays import Arrays
from sym2real.report.html.charts import Chart, Line
from sym2real.report.html.page import Figures, Page, Part, Section, Table
from sym2real.report.html.pages import ADDED, model_page
from sym2real.report.html.variants import Given, Predicting, Switch
from sym2real.report.tables import number


def adaptation_page(
    models: tuple[Predicting, Predicting], data: Dataset, reports: Sequence[RoundReport], on_top: int, title: str
) -> Page:
    """The model that was given and the adapted one on logs that neither has learned from, and every round.

    Args:
        models: both, that predict in float64.
        data: logs of the rounds from ``on_top`` on.
        reports: of every round.
        on_top: round of the adapted model.
        title: of the page.
    """
    arrays, switch = Arrays(), Switch("what was learned", f"the model of round {on_top}")
    best = reports[on_top]
    learned = f"from {best.learned.rows} rows" if on_top else "nothing: the model that was given is the best"
    horizon = f"{best.horizon:.3g} s ahead"
    reading = f"Learned {learned}; {horizon} its position is {number(best.prediction, 2)} m off on an unseen log."
    better = "Better than the best model before, with its 95 % interval."
    table = Table("Rounds", rounds_headings(reports), rounds_rows(reports, on_top), better)
    parts: list[Part] = [Figures("Every round", _charts(reports, arrays)), table]
    added = Section("added", ADDED, parts)
    return model_page(Given(models, (switch,)), data, title, summary=reading, added=added, arrays=arrays)


def _charts(reports: Sequence[RoundReport], arrays: Arrays) -> list[Chart]:
    arrays.add("rounds", np.array([float(report.number) for report in reports]))
    charts, first = [], reports[0]
    about = {
        "error": ("position error of the episodes", "mean distance from the reference"),
        "prediction": (f"prediction error {first.horizon:.3g} s ahead", "on the round's own log, which is unseen"),
    }
    for name, (title, label) in about.items():
        values = np.array([getattr(report, name) for report in reports])
        if np.isfinite(values).any():
            lines = [Line(label, "model", arrays.add(f"rounds-{name}", values))]
            ends = [number(float(value), 2) for value in values[np.isfinite(values)][[0, -1]]]
            reading = f"{ends[0]} m in the first round, {ends[1]} m in the last."
            labels = ("trajectories learned from", "error in m")
            charts.append(Chart(title, reading, *labels, "rounds", lines, zero=True, points=True))
    return charts
