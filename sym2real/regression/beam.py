"""Beam search, the default engine: every equation is its column plus a short sum of products of variables.

    s′ = s + Σ_k c_k Π_i v_i^p_ki

Candidates are all products to degree 3 of states, actions, inputs and sine and cosine of declared angles; the terms
are found by beam search on one Gram matrix (:mod:`sym2real.regression.search`), their number by an error on rows
held back, and the numbers by a fit on all rows. Wrench inputs come last, from the pushed rows, in terms that vanish
without a wrench.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy

from sym2real.errors import ModelError
from sym2real.regression.features import Variables
from sym2real.regression.monomials import Monomials
from sym2real.regression.polynomial import Polynomial, polynomial_of
from sym2real.regression.refit import Loss
from sym2real.regression.report import EquationReport, Fit, OnEquation, no_callback
from sym2real.regression.selection import SearchSettings
from sym2real.regression.stage import Stage
from sym2real.symbolic import Equations, complexity
from sym2real.trajectory import Transitions

FEWEST_ROWS = 20


@dataclass(frozen=True)
class BeamSearch:
    """Symbolic regression by beam search.

    Args:
        angles: columns whose sine and cosine may stand in equations (rad).
        loss: that the numbers are fitted with: "l1" (the paper's) or "l2".
        seed: its parity says which of the interleaved blocks validate; nothing else is random.
        wrench: learn the wrench inputs from rows where the wrench is not zero.
        degree: of the candidates, before growth.
        nodes: most nodes in an equation.
        wrench_nodes: how many of them are kept for wrench terms, where there are wrench inputs, learned or not: so
            an equation is the same with the wrench at zero as without it.
        search: how the search goes.
        on_equation: told the state column that is worked on next.
    """

    angles: Sequence[str] = ()
    loss: Loss = "l1"
    seed: int = 0
    wrench: bool = True
    degree: int = 3
    nodes: int = 85
    wrench_nodes: int = 20
    search: SearchSettings = field(default_factory=SearchSettings)
    on_equation: OnEquation = field(default=no_callback, repr=False, compare=False)

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions; see :meth:`fit_reported`."""
        return self.fit_reported(transitions, start).equations

    def fit_reported(self, transitions: Transitions, start: Equations | None = None) -> Fit:
        """Equations for these transitions and how each was found.

        Args:
            transitions: rows with a wrench of zero give the equations without wrench; the others the wrench terms.
            start: earlier equations; their terms are kept, and searched again only where the newest trajectory is
                predicted more than twice as badly as the ones before.

        Raises:
            ModelError: when fewer than 20 rows are without wrench.
        """
        variables = Variables.of(transitions.layouts, self.angles)
        pushed = (variables.wrench_of(transitions) != 0).any(axis=1)
        if (~pushed).sum() < FEWEST_ROWS:
            raise ModelError(
                f"beam search needs at least {FEWEST_ROWS} transitions without wrench, found {(~pushed).sum()}"
            )
        base = self._stage(transitions.where(~pushed), variables, self._candidates(variables))
        push = None
        if self.wrench and pushed.sum() >= FEWEST_ROWS:
            push = self._stage(transitions.where(pushed), variables, self._wrench_candidates(variables))
        expressions, reports = {}, []
        for column in transitions.layouts.state:
            self.on_equation(column)
            earlier = None if start is None else polynomial_of(start.next[column], column, variables)
            expressions[column], report = self._equation(column, base, push, earlier)
            reports.append(report)
        return Fit(Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt), tuple(reports))

    def _stage(self, transitions: Transitions, variables: Variables, candidates: Monomials) -> Stage:
        multipliers = range(variables.plain)
        return Stage(
            transitions,
            variables,
            candidates,
            multipliers=multipliers,
            search=self.search,
            loss=self.loss,
            seed=self.seed,
        )

    def _candidates(self, variables: Variables) -> Monomials:
        plain = Monomials.to_degree(variables.plain, self.degree)
        return Monomials(np.pad(plain.powers, ((0, 0), (0, len(variables.wrench)))))

    def _wrench_candidates(self, variables: Variables) -> Monomials:
        """One wrench column times every product of the others to one degree less."""
        plain = Monomials.to_degree(variables.plain, self.degree - 1).powers
        wrench = np.eye(len(variables.wrench), dtype=np.int64)
        rows = np.hstack([np.tile(plain, (len(wrench), 1)), np.repeat(wrench, len(plain), axis=0)])
        return Monomials.of(rows.tolist(), rows.shape[1])

    def _equation(
        self, column: str, base: Stage, push: Stage | None, earlier: Polynomial | None
    ) -> tuple[sympy.Expr, EquationReport]:
        variables, started = base.variables, time.process_time()
        free, wrenched = _split(earlier, variables)
        reserve = self.wrench_nodes if variables.wrench else 0
        part = base.solve(
            column,
            base.increments(column),
            free,
            lambda polynomial: polynomial.nodes(column, variables) <= self.nodes - reserve,
        )
        whole, searched, error = part.polynomial, part.searched, part.error
        if push is not None:
            left = push.increments(column) - whole.evaluate(push.values)
            addition = push.solve(
                column,
                left,
                wrenched,
                lambda polynomial: (part.polynomial + polynomial).nodes(column, variables) <= self.nodes,
            )
            whole, searched, error = (
                whole + addition.polynomial,
                searched or addition.searched,
                max(error, addition.error),
            )
        elif wrenched is not None:
            whole = whole + wrenched
        expression = whole.expression(column, variables)
        report = EquationReport(
            column, len(whole), complexity(expression), error, time.process_time() - started, searched
        )
        return expression, report


def _split(earlier: Polynomial | None, variables: Variables) -> tuple[Polynomial | None, Polynomial | None]:
    """The terms without a wrench, and those with one; None where there are none to start from."""
    if earlier is None:
        return None, None
    wrenched = earlier.terms.powers[:, variables.plain :].sum(axis=1) > 0
    return earlier.where(~wrenched), earlier.where(wrenched) if wrenched.any() else None
