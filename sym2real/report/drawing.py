"""All figures of a comparison, a diagnosis or the test of an effect into a folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from sym2real.dataset import Dataset
from sym2real.diagnosis import Comparison, Diagnosis, Tried, Where, window_errors
from sym2real.files import safe_name
from sym2real.protocols import DynamicsModel
from sym2real.report.error_figures import ladder_figure, over_time_figure, where_figure
from sym2real.report.figures import comparison_figure, predictions_of
from sym2real.report.style import save
from sym2real.symbolic import Equations

Predicting = Equations | DynamicsModel
MOST_PREDICTED = 4  # logs that get a figure of their own


def draw_comparison(model: Predicting, data: Dataset, comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures of a comparison; one of predictions for each of the first logs."""
    figures = {"error_over_horizon": comparison_figure(comparison)}
    return list(_save(figures | _errors({"model": model}, data, comparison.where), folder))


def draw_found(
    models: Mapping[str, Predicting], data: Dataset, found: Diagnosis | Tried, folder: Path
) -> Iterator[Path]:
    """Write the figures of a diagnosis or of the test of an effect, one after the other.

    Args:
        models: the base and, where something was found, the informed model, by what they are called.
        data: logs without the faults that were found.
        found: its ladder, floor and statements are drawn.
        folder: is made where it is missing.
    """
    figures = {"ladder": ladder_figure(found.ladder, found.floor)} if found.ladder else {}
    where = found.where if isinstance(found, Diagnosis) else ()
    yield from _save(figures | _errors(models, data, where), folder)


def _errors(models: Mapping[str, Predicting], data: Dataset, where: Sequence[Where]) -> dict[str, Figure]:
    errors = {label: window_errors(model, data) for label, model in models.items()}
    figures = {"error_over_time": over_time_figure(errors), "where": where_figure(errors, where)}
    predicted = predictions_of(models, Dataset(list(data)[:MOST_PREDICTED]))
    return figures | {f"{safe_name(name)}_predicted": figure for name, figure in predicted.items()}


def _save(figures: Mapping[str, Figure], folder: Path) -> Iterator[Path]:
    for name, figure in figures.items():
        yield save(figure, folder, safe_name(name))
