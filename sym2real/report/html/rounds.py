"""The page of an adaptation: what another trajectory has brought, and the model before and after it."""

from __future__ import annotations

from sym2real.adaptation import Adaptation
from sym2real.dataset import Dataset
from sym2real.diagnosis import compare
from sym2real.neural.composed import in_double
from sym2real.report.adaptation import rounds_charts, rounds_headings, rounds_rows
from sym2real.report.html.page import Figures, Page, Table
from sym2real.report.html.pages import model_page
from sym2real.report.html.variants import Given, Switch
from sym2real.report.tables import number


def adaptation_page(adaptation: Adaptation, title: str) -> Page:
    """The model that was given and the adapted one on logs that neither has learned from, and every round."""
    reports, on_top = adaptation.reports, adaptation.best
    models = tuple(in_double(adaptation.models[number]) for number in (0, on_top))
    data = Dataset(log for logs in adaptation.logs[on_top:] for log in logs)
    best, switch = reports[on_top], Switch("what was learned", f"the model of round {on_top}")
    learned = f"from {best.learned.rows} rows" if on_top else "nothing: the model that was given is the best"
    horizon = f"{best.horizon:.3g} s ahead"
    summary = f"Learned {learned}; {horizon} its position is {number(best.prediction, 2)} m off on an unseen log."
    better = "Better than the best model before, with its 95 % interval."
    table = Table("Rounds", rounds_headings(reports), rounds_rows(reports, on_top), better)
    added = (Figures("Every round", rounds_charts(reports)), table)
    return model_page(Given(models, (switch,)), data, title, compare(models[0], data), summary, added=added)
