"""PySR with the paper's settings, in one worker process for the whole Stage I loop.

M. Cranmer, "Interpretable Machine Learning for Science with PySR and SymbolicRegression.jl", 2023. Operators + − ×
cos sin, at most 85 nodes, 5 iterations, warm start, ℓ1 loss (the paper, section "Approach").
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy

from sym2real.dataset import Transitions
from sym2real.errors import MissingDependencyError, ModelError
from sym2real.regression.features import Variables
from sym2real.regression.numeric import columns_of
from sym2real.regression.worker_process import WorkerError, WorkerProcess
from sym2real.regression.wrench import pushed_rows, with_wrench
from sym2real.symbolic import Equations, complexity, parse_expression
from sym2real.trajectory import Array

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
    "the engine 'pysr' needs PySR and Julia. Install them with:\n"
    "    pip install 'sym2real[pysr]'\n"
    "    python -c 'import pysr'    # downloads Julia once, a few minutes\n"
    "or take the engine 'beam', which needs neither"
)


def julia_is_there() -> bool:
    """Whether PySR is installed and a Julia that it would use; neither is imported or downloaded."""
    if importlib.util.find_spec("pysr") is None:
        return False
    if os.environ.get("PYTHON_JULIAPKG_EXE") or shutil.which("julia"):
        return True
    return any(_names_julia(folder / "pyjuliapkg" / "meta.json") for folder in _julia_projects())


def _julia_projects() -> list[Path]:
    """Where juliapkg keeps its record of the Julia it uses (juliapkg 0.1, state.py)."""
    named = os.environ.get("PYTHON_JULIAPKG_PROJECT")
    if named:
        return [Path(named)]
    if sys.prefix != sys.base_prefix:
        return [Path(sys.prefix) / "julia_env"]
    if conda := os.environ.get("CONDA_PREFIX"):
        return [Path(conda) / "julia_env"]
    depot = os.environ.get("JULIA_DEPOT_PATH", "").split(os.pathsep)[0] or "~/.julia"
    return [Path(depot).expanduser() / "environments" / "pyjuliapkg"]


def _names_julia(meta: Path) -> bool:
    try:
        return Path(json.loads(meta.read_text(encoding="utf-8"))["executable"]).exists()
    except (OSError, ValueError, KeyError, TypeError):
        return False


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
        MissingDependencyError: when PySR or Julia is not there, with the commands that install them.

    Examples:
        >>> PySR(seed=1)  # doctest: +SKIP
    """

    def __init__(
        self,
        angles: Sequence[str] = (),
        seed: int = 0,
        *,
        nodes: int = 85,
        wrench: bool = True,
        factory: str = FACTORY,
    ) -> None:
        if factory == FACTORY and not julia_is_there():
            raise MissingDependencyError(INSTALL)
        self.angles, self.seed, self.nodes, self.wrench = tuple(angles), seed, nodes, wrench
        self.factory = factory
        self._worker: WorkerProcess | None = None

    def __repr__(self) -> str:
        return f"PySR(angles={self.angles!r}, seed={self.seed}, nodes={self.nodes}, wrench={self.wrench})"

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions.

        Args:
            transitions: rows with a wrench of zero give the equations; the others the wrench terms.
            start: given, the regressors that this object's last fit left go on; else they start afresh.

        Raises:
            MissingDependencyError: when the worker cannot import PySR.
            ModelError: when a search fails.
        """
        variables = Variables.of(transitions.layouts, self.angles)
        rows = transitions.where(~pushed_rows(transitions, variables))
        columns = columns_of(rows)
        causes = [column for column in variables.columns if np.ptp(columns[column]) > 0]
        values = np.stack([columns[column] for column in causes], axis=1)
        expressions = {
            column: self._search(column, values, rows.next_state[:, position], causes, start is None)
            for position, column in enumerate(transitions.layouts.state)
        }
        equations = Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt)
        return with_wrench(equations, transitions, variables, self.nodes, self.seed) if self.wrench else equations

    def close(self) -> None:
        """End the worker; a later fit starts a new one, which knows of no earlier fit."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    def _search(self, column: str, values: Array, target: Array, names: list[str], fresh: bool) -> sympy.Expr:
        worker = self._running_worker()
        text = worker.ask("fit", column=column, values=values, target=target, names=names, fresh=fresh)
        return expression_of(text, names, self.nodes)

    def _running_worker(self) -> WorkerProcess:
        if self._worker is None:
            worker = WorkerProcess(WORKER)
            settings = {**SETTINGS, "maxsize": self.nodes, "random_state": self.seed}
            try:
                worker.ask("start", factory=self.factory, settings=settings)
            except WorkerError as error:
                worker.close()
                if error.kind in ("ImportError", "ModuleNotFoundError"):
                    raise MissingDependencyError(f"{error}\n{INSTALL}") from error
                raise
            self._worker = worker
        return self._worker


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
