"""One of the two halves of an equation: what holds without a wrench, or what a wrench adds."""

from collections.abc import Callable

import numpy as np

from sym2real.dataset import Transitions
from sym2real.regression.features import Variables, tangent_scale
from sym2real.regression.monomials import Monomials, Powers
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.refit import Loss, refit
from sym2real.regression.selection import FLOOR, Choice, Pool, SearchSettings
from sym2real.regression.windows import Values, Windows
from sym2real.trajectory import Array

# A warm start is searched again where the newest trajectory is predicted so much worse than the ones before.
SURPRISE = 2.0
# Rows further off than so many median errors have less weight in the second choice.
FAR_OFF = 3.0
# No row has less weight: the few rows that leave the calm region are what shows the terms that act there.
LEAST_WEIGHT = 0.03


class Stage:
    """Rows and candidates of one half, shared by all equations.

    Args:
        transitions: the rows.
        variables: what the terms are made of.
        candidates: products to choose from.
        seed: shifts the blocks of rows that validate each other.
        window: rows over which changes and terms are averaged.
        noisy: where rows are, terms that explain only together are looked for too, as noise hides them one by one, and
            their number is judged by windows that begin among rows which had no part in choosing them.
    """

    def __init__(
        self,
        transitions: Transitions,
        variables: Variables,
        candidates: Monomials,
        *,
        search: SearchSettings,
        loss: Loss,
        seed: int,
        window: int = 1,
        noisy: bool = False,
    ) -> None:
        self.transitions, self.variables, self.loss = transitions, variables, loss
        self.candidates, self.search, self.noisy = candidates, search, noisy
        self.values = variables.values_of(transitions)
        scale = np.sqrt(np.mean(self.values**2, axis=0))
        self.scale = np.where(scale > 0, scale, 1.0)
        self.windows = Windows.of(transitions, window)
        self.newest = transitions.trajectory == transitions.trajectory.max()
        self.scaled = Values(self.values / self.scale, self.windows)
        self.held = self.windows.validating(transitions, seed)
        self._pools: dict[bytes, Pool] = {}

    def increments(self, column: str) -> Array:
        """What a step adds to a state column ``# (rows,)``; of a component of a manifold on its tangent."""
        layout = self.transitions.layouts.state
        position = layout.index(column)
        after = self.transitions.next_state[:, position]
        field = next(field for field in layout.fields if column in field.columns)
        if field.kind != "vector":
            after = after * tangent_scale(self.transitions, field.columns)
        return after - self.transitions.state[:, position]

    def solve(
        self, column: str, target: Array, earlier: Polynomial | None, fits: Callable[[Polynomial], bool]
    ) -> Polynomial:
        """Terms and numbers for a target ``# (rows,)``.

        Args:
            column: state column of the equation.
            target: what the terms shall sum up to.
            earlier: terms of a warm start; kept unless the newest trajectory surprises them.
            fits: whether the equation with these terms is small enough.
        """
        if earlier is not None and not self._surprised(earlier, target):
            return self._fitted(earlier.terms, target, fits)
        return self._fitted(self._chosen(self.windows.averaged(target), self.variables.sign_of(column)), target, fits)

    def _chosen(self, target: Array, sign: Powers) -> Monomials:
        """Terms for a target ``# (windows,)`` of a sign pattern.

        Chosen twice: rows that the first choice leaves far off have less weight in the second (Huber's), so that a
        few rows of another regime, such as wheels that slip, do not hide what the many obey.
        """
        spread = float(target.std())
        if spread <= 1e-14 * float(np.abs(target).max(initial=0.0)) or spread == 0.0:
            spread = 1.0
        target, ones, key = target / spread, np.ones(len(target)), sign.tobytes()
        if key not in self._pools:
            self._pools[key] = Pool.of(self._of_sign(self.candidates, sign), self.scaled, ones, self.held)
        pool = self._pools[key]
        choice = self._grown(pool, target, ones, sign)
        if choice.error > FLOOR:
            columns = self.scaled.of(choice.terms)
            wrong = np.abs(target - columns @ refit(columns, target, "l1"))
            share = FAR_OFF * np.median(wrong) / np.maximum(wrong, np.finfo(float).tiny)
            weights = np.sqrt(np.clip(share, LEAST_WEIGHT, 1.0))
            weighted = Pool.of(pool.terms, self.scaled, weights, self.held)
            choice = self._grown(weighted, target * weights, weights, sign)
        return choice.terms

    def _of_sign(self, terms: Monomials, sign: Powers) -> Monomials:
        return terms.where((self.variables.signs(terms.powers) == sign).all(axis=1))

    def _grown(self, pool: Pool, target: Array, weights: Array, sign: Powers) -> Choice:
        """Terms for a weighted target: what is chosen is multiplied by further factors and chosen from again."""
        choice = pool.choose(target, self.search, noisy=self.noisy)
        for _ in range(self.search.rounds):
            fresh = self._of_sign(choice.terms.times(self.variables.multipliers), sign)
            fresh = fresh.without(pool.terms, self.search.growth)
            if not len(fresh):
                break
            pool = pool.grown(fresh, self.scaled, weights)
            better = pool.choose(target, self.search, noisy=self.noisy)
            if better.score >= choice.score:
                break
            choice = better
        return choice

    def _surprised(self, earlier: Polynomial, target: Array) -> bool:
        if self.newest.all():
            return True
        wrong = (target - earlier.evaluate(self.values)) ** 2
        return bool(np.sqrt(wrong[self.newest].mean()) > SURPRISE * np.sqrt(wrong[~self.newest].mean()))

    def _fitted(self, terms: Monomials, target: Array, fits: Callable[[Polynomial], bool]) -> Polynomial:
        columns, target = self.scaled.of(terms), self.windows.averaged(target)
        units = np.prod(self.scale**terms.powers, axis=1)
        while len(terms) and not fits(Polynomial(terms, refit(columns, target, "l2") / units)):
            kept = np.arange(len(terms)) != _least_useful(columns, target)
            terms, columns, units = terms.where(kept), columns[:, kept], units[kept]
        return Polynomial(terms, refit(columns, target, self.loss) / units)


def _least_useful(columns: Array, target: Array) -> int:
    """The column whose loss raises the residual sum of squares least: smallest c_k² / (XᵀX)⁻¹_kk."""
    inverse = np.linalg.pinv(columns.T @ columns, hermitian=True)
    coefficients = inverse @ (columns.T @ target)
    return int(np.argmin(coefficients**2 / np.maximum(np.diag(inverse), np.finfo(float).tiny)))
