"""All figures of a comparison, a diagnosis or the test of an effect into a folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from matplotlib.figure import Figure

from sym2real.dataset import Dataset
from sym2real.diagnosis import Comparison, Diagnosis, Tried
from sym2real.files import safe_name
from sym2real.report.figures import comparison_figure, ladder_figure, predictions_of
from sym2real.report.html.variants import Predicting
from sym2real.report.style import save

MOST_PREDICTED = 4  # logs that get a figure of their own


def draw_comparison(model: Predicting, data: Dataset, comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures of a comparison; one of predictions for each of the first logs."""
    figures = {"error_over_horizon": comparison_figure(comparison)}
    return list(_save(figures | _predictions({"model": model}, data), folder))


def draw_found(
    models: Mapping[str, Predicting], data: Dataset, found: Diagnosis | Tried, folder: Path
) -> Iterator[Path]:
    """Write the figures of a diagnosis or of the test of an effect, one after the other.

    Args:
        models: the base and, where something was found, the informed model, by what they are called.
        data: logs without the faults that were found.
        found: its ladder and floor are drawn.
        folder: is made where it is missing.
    """
    figures = {"ladder": ladder_figure(found.ladder, found.floor)} if found.ladder else {}
    yield from _save(figures | _predictions(models, data), folder)


def _predictions(models: Mapping[str, Predicting], data: Dataset) -> dict[str, Figure]:
    predicted = predictions_of(models, Dataset(list(data)[:MOST_PREDICTED]))
    return {f"{name}_predicted": figure for name, figure in predicted.items()}


def _save(figures: Mapping[str, Figure], folder: Path) -> Iterator[Path]:
    for name, figure in figures.items():
        yield save(figure, folder, safe_name(name))
