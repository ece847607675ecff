"""What a fit did, equation by equation, for whoever shows it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import sympy

from sym2real.regression.numeric import one_step_errors
from sym2real.symbolic import Equations, complexity
from sym2real.trajectory import Transitions

OnEquation = Callable[[str], None]


def no_callback(_: str) -> None:
    """Nothing to be told."""


@dataclass(frozen=True)
class EquationReport:
    """One equation's way through a fit.

    Args:
        name: state column.
        terms: number of terms that are added up.
        nodes: nodes on the binary tree.
        validation_error: root mean square one-step error on rows without wrench that the search did not see, in the
            column's unit; NaN where the engine holds none back.
        seconds: time spent, of this process' CPU or, for worker processes, on the clock.
        searched: false where a warm start only refitted the numbers.
    """

    name: str
    terms: int
    nodes: int
    validation_error: float
    seconds: float
    searched: bool = True


@dataclass(frozen=True)
class Fit:
    """Equations and how they came about, one report per equation."""

    equations: Equations
    reports: tuple[EquationReport, ...]


def searched_reports(equations: Equations, seconds: Mapping[str, float]) -> tuple[EquationReport, ...]:
    """Reports of an engine that searches every equation and holds no rows back; its seconds are of wall clock."""
    return tuple(
        EquationReport(
            column, len(sympy.Add.make_args(expression)), complexity(expression), float("nan"), seconds[column]
        )
        for column, expression in equations.next.items()
    )


def fit_quality(equations: Equations, transitions: Transitions) -> dict[str, float]:
    """Root mean square one-step error of every state column, in its unit, whatever engine made the equations."""
    return {
        column: float(np.sqrt(np.mean(wrong**2))) for column, wrong in one_step_errors(equations, transitions).items()
    }
