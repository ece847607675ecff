"""The page of an adaptation: what another trajectory has brought, and the model before and after it."""

from __future__ import annotations

from collections.abc import Sequence

from sym2real.adaptation import RoundReport
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.report.adaptation import rounds_charts, rounds_headings, rounds_rows
from sym2real.report.html.page import Figures, Page, Table
from sym2real.report.html.pages import model_page
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
    best, switch = reports[on_top], Switch("what was learned", f"the model of round {on_top}")
    learned = f"from {best.learned.rows} rows" if on_top else "nothing: the model that was given is the best"
    horizon = f"{best.horizon:.3g} s ahead"
    summary = f"Learned {learned}; {horizon} its position is {number(best.prediction, 2)} m off on an unseen log."
    better = "Better than the best model before, with its 95 % interval."
    table = Table("Rounds", rounds_headings(reports), rounds_rows(reports, on_top), better)
    added = (Figures("Every round", rounds_charts(reports)), table)
    return model_page(Given(models, (switch,)), data, title, compare(models[0], data), summary, added=added)
