"""Wrench inputs: terms that rows under a wrench add to equations, each zero where there is no wrench."""

from dataclasses import replace

import numpy as np
import sympy
from numpy.typing import NDArray

from sym2real.dataset import Transitions
from sym2real.errors import ModelError
from sym2real.regression.features import Variables
from sym2real.regression.monomials import Monomials
from sym2real.regression.numeric import one_step_errors
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.refit import Loss
from sym2real.regression.selection import SearchSettings
from sym2real.regression.stage import Stage
from sym2real.symbolic import Equations, complexity

FEWEST_ROWS = 20
# Wrench column times products of the others: this many factors in all, before growth.
DEGREE = 3


def rows_with_wrench(transitions: Transitions, variables: Variables) -> NDArray[np.bool_]:
    """Where the wrench is not zero ``# (rows,)``.

    Raises:
        ModelError: when fewer than 20 rows are without wrench.
    """
    pushes = transitions.layouts.inputs.indices(variables.wrench)
    wrenched: NDArray[np.bool_] = (transitions.inputs[:, pushes] != 0).any(axis=1)
    if (~wrenched).sum() < FEWEST_ROWS:
        raise ModelError(f"expected at least {FEWEST_ROWS} transitions without wrench, found {(~wrenched).sum()}")
    return wrenched


def wrench_stage(
    transitions: Transitions, variables: Variables, search: SearchSettings, loss: Loss, seed: int
) -> Stage | None:
    """Rows and candidates of the wrench terms; None where hardly any row is under a wrench."""
    wrenched = rows_with_wrench(transitions, variables)
    if wrenched.sum() < FEWEST_ROWS:
        return None
    return Stage(transitions.where(wrenched), variables, _candidates(variables), search=search, loss=loss, seed=seed)


def with_wrench(
    equations: Equations, transitions: Transitions, variables: Variables, nodes: int, seed: int
) -> Equations:
    """Equations of any engine and the wrench terms that beam search finds for what they leave of rows under one."""
    stage = wrench_stage(transitions, variables, SearchSettings(), "l1", seed)
    if stage is None:
        return equations
    left = one_step_errors(equations, stage.transitions)
    added = {}
    for column, base in equations.next.items():

        def total(terms: Polynomial, base: sympy.Expr = base) -> sympy.Expr:
            return sympy.Add(base, terms.increment(variables))

        def fits(terms: Polynomial, base: sympy.Expr = base) -> bool:
            return complexity(total(terms, base)) <= nodes

        added[column] = total(stage.solve(column, left[column], None, fits))
    return replace(equations, next=added)


def _candidates(variables: Variables) -> Monomials:
    """One wrench column times every product of the other variables to one degree less."""
    plain = Monomials.to_degree(variables.plain, DEGREE - 1).powers
    wrench = np.eye(len(variables.wrench), dtype=np.int64)
    rows = np.hstack([np.tile(plain, (len(wrench), 1)), np.repeat(wrench, len(plain), axis=0)])
    return Monomials.of(rows.tolist(), rows.shape[1])
