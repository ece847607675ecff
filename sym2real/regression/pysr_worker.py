"""The process that PySR lives in, a script of its own: one regressor per state column, kept for the whole loop.

A request on standard input is a pickled ``(command, arguments)``, an answer on standard output ``(result, None)`` or
``(None, (type of the error, message))``. A regressor that is kept goes on from where its last fit ended
(``warm_start=True``). Nothing here imports torch, which must not share a process with Julia.
"""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


class Regressors:
    """Makes, keeps and fits regressors with PySR's interface."""

    def __init__(self) -> None:
        self._make: Any = None
        self._settings: dict[str, Any] = {}
        self._kept: dict[str, Any] = {}

    def start(self, factory: str, settings: dict[str, Any]) -> None:
        """Import what makes regressors, given as "module:attribute", and remember the keyword arguments."""
        module, attribute = factory.split(":")
        self._make, self._settings = getattr(import_module(module), attribute), settings

    def fit(self, column: str, values: Any, target: Any, names: list[str], fresh: bool) -> str:
        """Fit a column's regressor, a new one if ``fresh``; the equation that PySR selects from its hall of fame.

        Args:
            column: of the state.
            values: of the variables ``# (rows, variables)``.
            target: ``# (rows,)``.
            names: of the variables.
            fresh: whether what was found before is forgotten.
        """
        if fresh or column not in self._kept:
            self._kept[column] = self._make(**self._settings)
        regressor = self._kept[column]
        regressor.fit(values, target, variable_names=names)
        return str(regressor.get_best()["equation"])


def serve(commands: Mapping[str, Callable[..., Any]]) -> None:
    """Answer requests until standard input ends.

    The two streams are kept for the protocol alone: what libraries print goes to standard error, and what they read
    from standard input is empty.
    """
    with os.fdopen(os.dup(0), "rb") as requests, os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(2, 1)
        while requests.peek(1):
            command, arguments = pickle.load(requests)
            try:
                answer: tuple[Any, Any] = commands[command](**arguments), None
            except KeyboardInterrupt:
                raise
            # Whatever goes wrong in the engine is told to the process that asked; this one goes on.
            except BaseException as error:
                answer = None, (type(error).__name__, str(error))
            pickle.dump(answer, answers)
            answers.flush()


if __name__ == "__main__":
    regressors = Regressors()
    serve({"start": regressors.start, "fit": regressors.fit})
