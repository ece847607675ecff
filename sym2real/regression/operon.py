"""Operon: genetic programming in C++, in worker processes.

B. Burlacu, G. Kronberger, M. Kommenda, "Operon C++: an efficient genetic programming framework for symbolic
regression", GECCO 2020. Targets are increments s′ − s (next-state targets fit markedly worse); functions + − ×
over the columns and the sine and cosine of declared angles.
"""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy

from sym2real.errors import MissingDependencyError, ModelError
from sym2real.regression.features import Variables
from sym2real.regression.polynomial import generators
from sym2real.regression.report import Fit, OnEquation, no_callback, searched_reports
from sym2real.regression.worker_loop import encode
from sym2real.regression.worker_process import WorkerProcess
from sym2real.regression.wrench import pushed_rows, with_wrench
from sym2real.symbolic import Equations, complexity, parse_expression, symbol
from sym2real.trajectory import Array, Transitions

SETTINGS: Mapping[str, Any] = MappingProxyType(
    {
        "allowed_symbols": "add,sub,mul,constant,variable",
        "objectives": ["nmse", "length"],
        "model_selection_criterion": "mean_squared_error",
        "max_length": 81,  # Operon itself exceeds it by up to 4
        "max_depth": 20,
        "epsilon": 1e-9,
        "optimizer_iterations": 5,
        "n_threads": 1,  # more threads make runs of one seed differ
    }
)
INSTALL = "the engine 'operon' needs pyoperon: pip install 'sym2real[operon]'; the engine 'beam' needs nothing"


@dataclass(frozen=True)
class Operon:
    """Symbolic regression by Operon.

    Args:
        angles: columns whose sine and cosine may stand in equations (rad).
        seed: of the random numbers; the same seed gives the same equations.
        nodes: most nodes in an equation.
        wrench_nodes: how many of them are kept for wrench terms where there are wrench inputs.
        wrench: learn the wrench inputs, by beam search, from rows where the wrench is not zero.
        population: trees.
        generations: at most so many.
        processes: workers; 0 for one per core.
        on_equation: told the state column that is finished next.

    Examples:
        >>> Operon(population=500, generations=100, seed=1).nodes
        85
    """

    angles: Sequence[str] = ()
    seed: int = 0
    nodes: int = 85
    wrench_nodes: int = 20
    wrench: bool = True
    population: int = 200
    generations: int = 40
    processes: int = 0
    on_equation: OnEquation = field(default=no_callback, repr=False, compare=False)

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions; see :meth:`fit_reported`."""
        return self.fit_reported(transitions, start).equations

    def fit_reported(self, transitions: Transitions, start: Equations | None = None) -> Fit:
        """Equations for these transitions and how each was found.

        Args:
            transitions: rows with a wrench of zero give the equations; the others the wrench terms.
            start: not used: every fit is a search of its own.

        Raises:
            MissingDependencyError: when pyoperon is not installed.
            ModelError: when a search fails.
        """
        if importlib.util.find_spec("pyoperon") is None:
            raise MissingDependencyError(INSTALL)
        variables = Variables.of(transitions.layouts, self.angles)
        rows = transitions.where(~pushed_rows(transitions, variables))
        expressions, seconds = self._search(rows, variables)
        equations = Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt)
        if self.wrench:
            equations = with_wrench(equations, transitions, variables, self.nodes, self.seed)
        return Fit(equations, searched_reports(equations, seconds))

    def _search(self, rows: Transitions, variables: Variables) -> tuple[dict[str, sympy.Expr], dict[str, float]]:
        """Columns go round the workers in turn; every worker gets its next one with its answer."""
        columns = list(rows.layouts.state)
        workers = [WorkerProcess("sym2real.regression.operon_worker") for _ in range(self._workers(len(columns)))]
        expressions: dict[str, sympy.Expr] = {}
        started: dict[str, float] = {}
        seconds: dict[str, float] = {}
        try:
            for position, column in enumerate(columns):
                if position >= len(workers):
                    done = columns[position - len(workers)]
                    expressions[done] = self._received(workers[position % len(workers)], done, rows, variables)
                    seconds[done] = time.perf_counter() - started[done]
                started[column] = time.perf_counter()
                workers[position % len(workers)].send("fit", **self._request(column, rows, variables))
            for position, column in enumerate(columns):
                if column not in expressions:
                    expressions[column] = self._received(workers[position % len(workers)], column, rows, variables)
                    seconds[column] = time.perf_counter() - started[column]
        finally:
            for worker in workers:
                worker.close()
        return expressions, seconds

    def _workers(self, columns: int) -> int:
        return min(self.processes or os.cpu_count() or 1, columns)

    def _request(self, column: str, rows: Transitions, variables: Variables) -> dict[str, Any]:
        values = variables.values_of(rows)[:, : variables.plain]
        scales = np.sqrt(np.mean(values**2, axis=0))
        alive = np.flatnonzero(np.ptp(values, axis=0) > 0)
        target, spread = _target(column, rows)
        return {
            "values": encode(values[:, alive] / scales[alive]),
            "target": encode(target / spread),
            "names": [str(generators(variables)[position]) for position in alive],
            "scales": scales[alive].tolist(),
            "settings": {
                **SETTINGS,
                "population_size": self.population,
                "generations": self.generations,
                "random_state": self.seed,
            },
        }

    def _received(self, worker: WorkerProcess, column: str, rows: Transitions, variables: Variables) -> sympy.Expr:
        self.on_equation(column)
        room = self.nodes - (self.wrench_nodes if variables.wrench else 0)
        spread = _target(column, rows)[1]
        names = (*variables.columns, *variables.wrench)
        for _, text in sorted(worker.receive()):
            expression = sympy.Add(symbol(column), parse_expression(f"({spread!r}) * {text}", names))
            if complexity(expression) <= room:
                return expression
        raise ModelError(f"Operon found no equation of at most {room} nodes for {column!r}")


def _target(column: str, rows: Transitions) -> tuple[Array, float]:
    """Increments of a column ``# (rows,)`` and their spread."""
    position = rows.layouts.state.index(column)
    target = rows.next_state[:, position] - rows.state[:, position]
    return target, float(target.std()) or 1.0
