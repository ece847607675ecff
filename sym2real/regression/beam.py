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
from threadpoolctl import threadpool_limits

from sym2real.regression.features import Variables
from sym2real.regression.monomials import Monomials
from sym2real.regression.polynomial import Polynomial, polynomial_of
from sym2real.regression.refit import Loss
from sym2real.regression.report import EquationReport, Fit, OnEquation, no_callback
from sym2real.regression.selection import SearchSettings
from sym2real.regression.stage import Part, Stage
from sym2real.regression.wrench import pushed_rows, wrench_stage
from sym2real.symbolic import Equations, complexity
from sym2real.trajectory import Transitions


@dataclass(frozen=True)
class BeamSearch:
    """Symbolic regression by beam search.

    Args:
        angles: columns whose sine and cosine may stand in equations (rad).
        loss: that the numbers are fitted with: "l1" (the paper's) or "l2".
        seed: shifts the blocks of rows that validate each other; nothing else is random.
        wrench: learn the wrench inputs from rows where the wrench is not zero.
        degree: of the candidates, before growth.
        nodes: most nodes in an equation.
        wrench_nodes: how many of them are kept for wrench terms, where there are wrench inputs, learned or not: so
            an equation is the same with the wrench at zero as without it.
        search: how the search goes.
        on_equation: told the state column that is worked on next.

    Examples:
        >>> robot = ROBOTS["mushr"]
        >>> task = make_task("circle", robot)
        >>> log = run_episode(MujocoPlant(robot), MPPI(compile_model(robot.nominal()), robot, task), task, steps=100)
        >>> found = BeamSearch(angles=robot.recipe.angles).fit(Dataset([log]).transitions())
        >>> max(found.complexity().values()) <= 85
        True
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
        # The matrices are so small that BLAS threads cost ten times what they gain.
        with threadpool_limits(limits=1, user_api="blas"):
            return self._fit(transitions, start)

    def _fit(self, transitions: Transitions, start: Equations | None) -> Fit:
        variables = Variables.of(transitions.layouts, self.angles)
        base = self._base_stage(transitions, variables)
        push = wrench_stage(transitions, variables, self.search, self.loss, self.seed) if self.wrench else None
        expressions, reports = {}, []
        for column in transitions.layouts.state:
            self.on_equation(column)
            earlier = None if start is None else polynomial_of(start.next[column], column, variables)
            expressions[column], report = self._equation(column, base, push, earlier)
            reports.append(report)
        return Fit(Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt), tuple(reports))

    def _base_stage(self, transitions: Transitions, variables: Variables) -> Stage:
        plain = Monomials.to_degree(variables.plain, self.degree)
        return Stage(
            transitions.where(~pushed_rows(transitions, variables)),
            variables,
            Monomials(np.pad(plain.powers, ((0, 0), (0, len(variables.wrench))))),
            search=self.search,
            loss=self.loss,
            seed=self.seed,
        )

    def _equation(
        self, column: str, base: Stage, push: Stage | None, earlier: Polynomial | None
    ) -> tuple[sympy.Expr, EquationReport]:
        variables, started = base.variables, time.process_time()
        free, wrenched = _split(earlier, variables)
        room = self.nodes - (self.wrench_nodes if variables.wrench else 0)
        part = base.solve(column, base.increments(column), free, lambda terms: terms.nodes(column, variables) <= room)
        added = self._wrench_part(column, part.polynomial, push, wrenched)
        whole = part.polynomial if added is None else part.polynomial + added.polynomial
        expression = whole.expression(column, variables)
        seconds = time.process_time() - started
        searched = part.searched or (added is not None and added.searched)
        report = EquationReport(column, len(whole), complexity(expression), part.error, seconds, searched)
        return expression, report

    def _wrench_part(
        self, column: str, base: Polynomial, push: Stage | None, earlier: Polynomial | None
    ) -> Part | None:
        if push is None:
            return Part(earlier, float("nan"), searched=False) if self.wrench and earlier is not None else None
        left = push.increments(column) - base.evaluate(push.values)
        variables = push.variables
        return push.solve(column, left, earlier, lambda terms: (base + terms).nodes(column, variables) <= self.nodes)


def _split(earlier: Polynomial | None, variables: Variables) -> tuple[Polynomial | None, Polynomial | None]:
    """The terms without a wrench, and those with one; None where there are none to start from."""
    if earlier is None:
        return None, None
    wrenched = earlier.terms.powers[:, variables.plain :].sum(axis=1) > 0
    return earlier.where(~wrenched), earlier.where(wrenched) if wrenched.any() else None
