"""Beam search, the default engine: every equation is its column plus a short sum of products of variables.

    s′ = s + Σ_k c_k Π_i v_i^p_ki

Candidates are all products to degree 3 of states, actions, inputs and sine and cosine of declared angles; the terms
are found by beam search on one Gram matrix (:mod:`sym2real.regression.search`), their number by an error on rows
held back, and the numbers by a fit on all rows. Wrench inputs come last, from the rows under one, in terms that vanish
without a wrench.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import sympy
from threadpoolctl import threadpool_limits

from sym2real.dataset import Transitions
from sym2real.regression.features import Variables
from sym2real.regression.free_run import FreeRuns, plainest
from sym2real.regression.polynomial import Polynomial, polynomial_of
from sym2real.regression.refit import Loss
from sym2real.regression.selection import SearchSettings
from sym2real.regression.stage import Stage
from sym2real.regression.windows import FEWEST, Windows
from sym2real.regression.wrench import rows_with_wrench, wrench_stage
from sym2real.symbolic import Equations


@dataclass(frozen=True)
class BeamSearch:
    """Symbolic regression by beam search.

    Args:
        angles: columns whose sine and cosine may stand in equations (rad).
        loss: that the numbers are fitted with, row by row: "l1" (the paper's) or "l2".
        seed: shifts the blocks of rows that validate each other; nothing else is random.
        wrench: learn the wrench inputs from rows where the wrench is not zero.
        degree: of the candidates, before growth.
        nodes: most nodes in an equation.
        wrench_nodes: how many of them are kept for wrench terms, where there are wrench inputs, learned or not: so
            an equation is the same with the wrench at zero as without it.
        search: how the search goes.
        cyclic: columns that no change depends on.
        windows: rows over which a state's changes are averaged. Of several, as for measured rows with their noise,
            every equation is the plainest of those that run best on their own over the longest (:mod:`.windows`).
        on_column: told the state column whose equation is searched next.

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
    cyclic: Sequence[str] = ()
    windows: Sequence[int] = (1,)
    on_column: Callable[[str], None] = field(default=lambda _: None, repr=False, compare=False)

    def fit(self, transitions: Transitions, start: Equations | None = None) -> Equations:
        """Equations for these transitions.

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

    def _fit(self, transitions: Transitions, start: Equations | None) -> Equations:
        variables = Variables.of(transitions.layouts, self.angles, self.cyclic)
        plain = transitions.where(~rows_with_wrench(transitions, variables))
        rows = [window for window in self.windows if len(Windows.of(plain, window).starts) >= FEWEST]
        bases = [self._base_stage(plain, variables, window) for window in rows or [1]]
        stage = wrench_stage(transitions, variables, self.search, self.loss, self.seed) if self.wrench else None
        expressions = {}
        for column in transitions.layouts.state:
            self.on_column(column)
            earlier = None if start is None else polynomial_of(start.next[column], column, variables)
            expressions[column] = self._equation(column, bases, stage, earlier)
        return Equations(next=expressions, layouts=transitions.layouts, dt=transitions.dt)

    def _base_stage(self, plain: Transitions, variables: Variables, window: int) -> Stage:
        return Stage(
            plain,
            variables,
            variables.products(self.degree),
            search=self.search,
            loss=self.loss,
            seed=self.seed,
            window=window,
            noisy=len(self.windows) > 1,
        )

    def _equation(
        self, column: str, bases: Sequence[Stage], stage: Stage | None, earlier: Polynomial | None
    ) -> sympy.Expr:
        variables = bases[0].variables
        free, wrenched = _split(earlier, variables)
        room = self.nodes - (self.wrench_nodes if variables.wrench else 0)
        candidates = [
            base.solve(column, base.increments(column), free, lambda terms: terms.nodes(column, variables) <= room)
            for base in bases
        ]
        terms = candidates[0] if len(candidates) == 1 else _running_best(candidates, column, bases)
        added = self._wrench_terms(column, terms, stage, wrenched)
        return (terms if added is None else terms + added).expression(column, variables)

    def _wrench_terms(
        self, column: str, base: Polynomial, stage: Stage | None, earlier: Polynomial | None
    ) -> Polynomial | None:
        if stage is None:
            return earlier if self.wrench else None
        left = stage.increments(column) - base.evaluate(stage.values)
        variables = stage.variables
        return stage.solve(column, left, earlier, lambda terms: (base + terms).nodes(column, variables) <= self.nodes)


def _running_best(candidates: Sequence[Polynomial], column: str, bases: Sequence[Stage]) -> Polynomial:
    longest = bases[-1]
    runs = FreeRuns(column, longest.variables, longest.transitions, longest.windows.rows)
    return runs.fitted(plainest(candidates, [runs.squares(terms) for terms in candidates]))


def _split(earlier: Polynomial | None, variables: Variables) -> tuple[Polynomial | None, Polynomial | None]:
    """The terms without a wrench, and those with one; None where there are none to start from."""
    if earlier is None:
        return None, None
    wrenched = earlier.terms.powers[:, variables.plain :].sum(axis=1) > 0
    return earlier.where(~wrenched), earlier.where(wrenched) if wrenched.any() else None
