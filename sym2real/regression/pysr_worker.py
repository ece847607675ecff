"""The process that PySR lives in, a script of its own: one regressor per state column, kept for the whole loop.

A request on standard input is the pickled arguments of :func:`fit`, an answer on standard output ``(equation, "")`` or
``("", what went wrong)``. Nothing here imports torch, which must not share a process with Julia.
"""

import os
import pickle
from importlib import import_module
from typing import Any


def fit(
    kept: dict[str, Any], factory: str, settings: dict[str, Any], column: str, *data: Any, names: list[str], fresh: bool
) -> str:
    """Fit a column's regressor; the equation that PySR selects from its hall of fame.

    Args:
        kept: regressors by column; one that is kept goes on from where its last fit ended (``warm_start=True``).
        factory: what makes regressors, as "module:attribute".
        settings: its keyword arguments.
        column: of the state.
        data: values of the variables ``# (rows, variables)``, and the target ``# (rows,)``.
        names: of the variables.
        fresh: whether what was found before is forgotten.
    """
    if fresh or column not in kept:
        module, attribute = factory.split(":")
        kept[column] = getattr(import_module(module), attribute)(**settings)
    kept[column].fit(*data, variable_names=names)
    return str(kept[column].get_best()["equation"])


def serve() -> None:
    """Answer requests until standard input ends.

    The two streams are kept for the protocol alone: what libraries print goes to standard error, and what they read
    from standard input is empty.
    """
    kept: dict[str, Any] = {}
    with os.fdopen(os.dup(0), "rb") as requests, os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(2, 1)
        while requests.peek(1):
            given, options = pickle.load(requests)
            try:
                answer = fit(kept, *given, **options), ""
            except KeyboardInterrupt:
                raise
            # Whatever goes wrong in the engine is told to the process that asked; this one goes on.
            except BaseException as error:
                answer = "", f"{type(error).__name__}: {error}"
            pickle.dump(answer, answers)
            answers.flush()


if __name__ == "__main__":
    serve()
