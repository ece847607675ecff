"""The process that PySR lives in: one regressor per state column, kept for the whole loop.

``python -m sym2real.regression.pysr_worker`` answers on standard output (:mod:`sym2real.regression.worker_loop`).
A regressor that is kept goes on from where its last fit ended (``warm_start=True``).
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from sym2real.regression.worker_loop import decode, serve


class Regressors:
    """Makes, keeps and fits regressors with PySR's interface."""

    def __init__(self) -> None:
        self._make: Any = None
        self._settings: dict[str, Any] = {}
        self._kept: dict[str, Any] = {}

    def start(self, factory: str, settings: dict[str, Any]) -> bool:
        """Import what makes regressors, given as "module:attribute", and remember the keyword arguments."""
        module, attribute = factory.split(":")
        self._make, self._settings = getattr(import_module(module), attribute), settings
        return True

    def fit(
        self, column: str, values: dict[str, Any], target: dict[str, Any], names: list[str], fresh: bool
    ) -> list[list[Any]]:
        """Fit a column's regressor, a new one if ``fresh``; its hall of fame as [complexity, loss, equation]."""
        if fresh or column not in self._kept:
            self._kept[column] = self._make(**self._settings)
        regressor = self._kept[column]
        regressor.fit(decode(values), decode(target), variable_names=names)
        table = regressor.equations_
        return [
            [int(complexity), float(loss), str(equation)]
            for complexity, loss, equation in zip(table["complexity"], table["loss"], table["equation"], strict=True)
        ]


if __name__ == "__main__":
    regressors = Regressors()
    serve({"start": regressors.start, "fit": regressors.fit})
