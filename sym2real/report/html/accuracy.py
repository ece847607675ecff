"""How good is the model? Errors over the horizon beside what the sensors' noise makes, "hold" and the mean."""

import numpy as np

from sym2real.diagnosis import Comparison
from sym2real.diagnosis.data.windows import JUDGED_AT
from sym2real.report.horizons import comparison_charts
from sym2real.report.html.observed import Observed
from sym2real.report.html.page import Errors, Figures, Section, Table
from sym2real.report.tables import decimals, number

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
        _table(comparison),
    )
    return Section("accuracy", QUESTION, parts)


def _table(comparison: Comparison) -> Table:
    """Every horizon with the errors of every channel; fit and skill at the last one below a free run."""
    channels = comparison.one_step.errors
    columns = ["horizon in s", *(f"{name} in {error.unit}" for name, error in channels.items()), "skill", "fit in %"]
    rows = []
    for errors in (comparison.one_step, *comparison.horizons, comparison.free_run):
        first = next(iter(errors.errors.values()))
        sizes = [number(error.value) for error in errors.errors.values()]
        rows.append([f"{errors.horizon:.3g}", *sizes, decimals(first.skill, 2), decimals(first.fit, 0)])
    name = next(iter(channels))
    reading = (
        f"Skill of {name} against hold (1 is perfect, 0 no better); fit of {name} against its mean. Last row: free run."
    )
    return Table("Every horizon", columns, rows, reading)
