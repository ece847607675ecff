"""Operon: genetic programming in C++, several equations at a time.

B. Burlacu, G. Kronberger, M. Kommenda, "Operon C++: an efficient genetic programming framework for symbolic
regression", GECCO 2020. Targets are increments s′ − s (next-state targets fit markedly worse); functions + − ×
over the columns and the sine and cosine of declared angles.
"""

import importlib.util
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy

from sym2real.dataset import Transitions
from sym2real.errors import MissingDependencyError, ModelError
from sym2real.regression.features import Variables
from sym2real.regression.polynomial import generators
from sym2real.regression.wrench import rows_with_wrench, with_wrench
from sym2real.symbolic import Equations, complexity, parse_expression, symbol
from sym2real.trajectory import Array

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
        threads: equations that are searched at a time; 0 for one per core.

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
    threads: int = 0

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions.

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
        rows = transitions.where(~rows_with_wrench(transitions, variables))
        columns = list(rows.layouts.state)
        # Operon lets go of the interpreter while it searches.
        with ThreadPoolExecutor(self.threads or os.cpu_count()) as pool:
            fronts = list(pool.map(lambda column: self._front(column, rows, variables), columns))
        expressions = {
            column: self._chosen(front, column, rows, variables) for column, front in zip(columns, fronts, strict=True)
        }
        equations = Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt)
        return with_wrench(equations, transitions, variables, self.nodes, self.seed) if self.wrench else equations

    def _front(self, column: str, rows: Transitions, variables: Variables) -> list[tuple[float, str]]:
        """Models of a column that none other beats in both error and length, as error and text."""
        from pyoperon.sklearn import SymbolicRegressor  # noqa: PLC0415 — an extra

        values = variables.values_of(rows)[:, : variables.plain]
        scales = np.sqrt(np.mean(values**2, axis=0))
        alive = np.flatnonzero(np.ptp(values, axis=0) > 0)
        names = [str(generators(variables)[position]) for position in alive]
        target, spread = _target(column, rows)
        regressor = SymbolicRegressor(
            **SETTINGS, population_size=self.population, generations=self.generations, random_state=self.seed
        )
        regressor.fit(values[:, alive] / scales[alive], target / spread)
        scaled = {
            key: (name, float(scale))
            for key, name, scale in zip(regressor.variables_, names, scales[alive], strict=True)
        }
        front = [(float(model["mean_squared_error"]) ** 0.5, model["tree"].Nodes) for model in regressor.pareto_front_]
        return [(error, tree_text(nodes, scaled)) for error, nodes in front]

    def _chosen(
        self, front: Sequence[tuple[float, str]], column: str, rows: Transitions, variables: Variables
    ) -> sympy.Expr:
        room = self.nodes - (self.wrench_nodes if variables.wrench else 0)
        spread = _target(column, rows)[1]
        names = (*variables.columns, *variables.wrench)
        for _, text in sorted(front):
            expression = sympy.Add(symbol(column), parse_expression(f"({spread!r}) * {text}", names))
            if complexity(expression) <= room:
                return expression
        raise ModelError(f"Operon found no equation of at most {room} nodes for {column!r}")


def tree_text(nodes: Sequence[Any], variables: Mapping[int, tuple[str, float]]) -> str:
    """A tree in postfix order as text with every operation in parentheses and every digit of its numbers.

    Operon's own formatter writes a fixed number of decimals, which cuts small coefficients short. The operands of a
    node stand before it, the first one last.

    Args:
        nodes: of the tree.
        variables: by Operon's number of a variable, its name and what its values were divided by.
    """
    stack: list[str] = []
    for node in nodes:
        kind = node.Type.name
        if kind == "Constant":
            stack.append(f"({float(node.Value)!r})")
        elif kind == "Variable":
            name, scale = variables[node.HashValue]
            stack.append(f"({float(node.Value) / scale!r} * {name})")
        else:
            operands = [stack.pop() for _ in range(node.Arity)]
            stack.append("(" + {"Add": " + ", "Sub": " - ", "Mul": " * "}[kind].join(operands) + ")")
    (text,) = stack
    return text


def _target(column: str, rows: Transitions) -> tuple[Array, float]:
    """Increments of a column ``# (rows,)`` and their spread."""
    position = rows.layouts.state.index(column)
    target = rows.next_state[:, position] - rows.state[:, position]
    return target, float(target.std()) or 1.0
