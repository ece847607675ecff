"""What a fit did, equation by equation, for whoever shows it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sym2real.symbolic import Equations

OnEquation = Callable[[str], None]


def no_callback(_: str) -> None:
    """Nothing to be told."""


@dataclass(frozen=True)
class EquationReport:
    """One equation's way through a fit.

    Args:
        name: state column.
        terms: number of terms, of the increment where the engine has such.
        nodes: nodes on the binary tree.
        validation_error: root mean square one-step error on rows held back from the search, in the column's unit.
        seconds: CPU time spent.
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
