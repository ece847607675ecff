"""How good is the model? Errors over the horizon beside what the sensors' noise makes, "hold" and the mean."""

import numpy as np

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.comparison import comparison_table, floor_table
from sym2real.report.horizons import comparison_charts
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Errors, Figures, Section

QUESTION = "How good is the model?"


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
        Errors(f"Error {ahead}", "Root mean square over windows that start every 0.1 s.", rows, shown),
        Figures("Error over the horizon", comparison_charts(comparison, observed.by_horizon)),
        comparison_table(comparison),
        floor_table(comparison),
    )
    return Section("accuracy", QUESTION, parts)
