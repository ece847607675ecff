"""PySR with the paper's settings, in one worker process for the whole Stage I loop.

M. Cranmer, "Interpretable Machine Learning for Science with PySR and SymbolicRegression.jl", 2023. Operators + − ×
cos sin, at most 85 nodes, 5 iterations, warm start, ℓ1 loss (the paper, section "Approach").
"""

import importlib.util
import pickle
import re
import subprocess
import sys
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy

from sym2real.dataset import Transitions
from sym2real.errors import MissingDependencyError, ModelError
from sym2real.regression.features import Variables
from sym2real.regression.numeric import columns_of
from sym2real.regression.wrench import rows_with_wrench, with_wrench
from sym2real.symbolic import Equations, complexity, parse_expression

FACTORY, WORKER = "pysr:PySRRegressor", Path(__file__).with_name("pysr_worker.py")
SETTINGS: Mapping[str, Any] = MappingProxyType(
    {
        "binary_operators": ["+", "-", "*"],
        "unary_operators": ["cos", "sin"],
        "maxsize": 85,
        "niterations": 5,
        "warm_start": True,
        "model_selection": "best",
        "elementwise_loss": "L1DistLoss()",
        "precision": 64,
        "progress": False,
        "verbosity": 0,
        "temp_equation_file": True,
    }
)
# Julia writes single precision numbers as 1.0f-5.
JULIA_FLOAT = re.compile(r"\b(\d+\.?\d*)[fF]([+-]?\d+)\b")
INSTALL = (
    "the engine 'pysr' needs PySR, which brings Julia when it is first imported, in a few minutes:\n"
    "    pip install 'sym2real[pysr]'\n"
    "    python -c 'import pysr'\n"
    "or take the engine 'beam', which needs neither"
)


class PySR:
    """Symbolic regression by PySR.

    Every column's next value is one search over rows without wrench; the wrench terms come from beam search.

    Args:
        angles: columns whose sine and cosine may stand in wrench terms (rad); PySR itself may take any column's.
        seed: of PySR's random numbers; its threads still make runs differ.
        nodes: most nodes in an equation.
        wrench: learn the wrench inputs from rows where the wrench is not zero.
        factory: what makes regressors, as "module:attribute" that the worker imports.

    Raises:
        MissingDependencyError: when PySR is not installed, with the commands that install it.

    Examples:
        >>> PySR(seed=1)  # doctest: +SKIP
    """

    def __init__(
        self, angles: Sequence[str] = (), seed: int = 0, *, nodes: int = 85, wrench: bool = True, factory: str = FACTORY
    ) -> None:
        if factory == FACTORY and importlib.util.find_spec("pysr") is None:
            raise MissingDependencyError(INSTALL)
        self.angles, self.seed, self.nodes, self.wrench = tuple(angles), seed, nodes, wrench
        self.factory = factory
        self._worker: subprocess.Popen[bytes] | None = None

    def __repr__(self) -> str:
        return f"PySR(angles={self.angles!r}, seed={self.seed}, nodes={self.nodes}, wrench={self.wrench})"

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions.

        Args:
            transitions: rows with a wrench of zero give the equations; the others the wrench terms.
            start: given, the regressors that this object's last fit left go on; else they start afresh.

        Raises:
            ModelError: when a search fails, or the worker has died.
        """
        variables = Variables.of(transitions.layouts, self.angles)
        rows = transitions.where(~rows_with_wrench(transitions, variables))
        columns = columns_of(rows)
        causes = [column for column in variables.columns if np.ptp(columns[column]) > 0]
        values = np.stack([columns[column] for column in causes], axis=1)
        expressions = {
            column: self._search(column, values, rows.next_state[:, position], names=causes, fresh=start is None)
            for position, column in enumerate(transitions.layouts.state)
        }
        equations = Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt)
        return with_wrench(equations, transitions, variables, self.nodes, self.seed) if self.wrench else equations

    def close(self) -> None:
        """End the worker; a later fit starts a new one, which knows of no earlier fit."""
        if self._worker is not None:
            _end(self._worker)
            self._worker = None

    def _search(self, column: str, *data: Any, names: list[str], fresh: bool) -> sympy.Expr:
        """An equation that the worker finds, whose last words are on the terminal if it dies."""
        if self._worker is None:  # the script's folder is none that it imports from
            command = [sys.executable, "-P", str(WORKER)]
            self._worker = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            weakref.finalize(self, _end, self._worker)
        assert self._worker.stdin is not None
        assert self._worker.stdout is not None
        settings = {**SETTINGS, "maxsize": self.nodes, "random_state": self.seed}
        try:
            request = (self.factory, settings, column, *data), {"names": names, "fresh": fresh}
            pickle.dump(request, self._worker.stdin)
            self._worker.stdin.flush()
            text, error = pickle.load(self._worker.stdout)
        except (BrokenPipeError, EOFError):
            raise ModelError(f"the regression worker ended with exit code {self._worker.wait()}") from None
        if error:
            raise ModelError(f"the regression worker failed: {error}")
        return expression_of(text, names, self.nodes)


def _end(process: subprocess.Popen[bytes]) -> None:
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with suppress(OSError):  # what a dead process was sent is still to be written
                stream.close()
    try:
        process.wait(timeout=2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def expression_of(text: str, names: Sequence[str], nodes: int) -> sympy.Expr:
    """PySR's text of an equation as an expression over these names.

    Raises:
        UnknownNameError: when it uses another name.
        ModelError: when the text is not such an expression or has more than ``nodes`` nodes.
    """
    expression = parse_expression(JULIA_FLOAT.sub(r"\1e\2", text).replace("^", "**"), names)
    if complexity(expression) > nodes:
        raise ModelError(f"expected at most {nodes} nodes, found {complexity(expression)} in {text[:60]!r}")
    return expression
