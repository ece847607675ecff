"""One of the two halves of an equation: what holds without a wrench, or what a wrench adds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sym2real.dataset import Transitions
from sym2real.regression.features import Variables, tangent_scale
from sym2real.regression.monomials import Monomials
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.refit import Loss, refit
from sym2real.regression.selection import SearchSettings, Table
from sym2real.regression.windows import Values, Windows
from sym2real.trajectory import Array

# A warm start is searched again where the newest trajectory is predicted so much worse than the ones before.
SURPRISE = 2.0


class Stage:
    """Rows and candidates of one half, shared by all equations.

    Args:
        transitions: the rows.
        variables: what the terms are made of.
        candidates: products to choose from.
        seed: shifts the blocks of rows that validate each other.
        window: rows over which changes and terms are averaged.
        noisy: as a :class:`Table` says.
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
        self.values = variables.values_of(transitions)
        scale = np.sqrt(np.mean(self.values**2, axis=0))
        self.scale = np.where(scale > 0, scale, 1.0)
        self.windows = Windows.of(transitions, window)
        self.newest = transitions.trajectory == transitions.trajectory.max()
        self.table = Table(
            Values(self.values / self.scale, self.windows),
            candidates,
            signs=variables.signs,
            multipliers=variables.multipliers,
            held=self.windows.validating(transitions, seed),
            settings=search,
            noisy=noisy,
        )

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
        chosen = self.table.choose(self.windows.averaged(target), self.variables.sign_of(column))
        return self._fitted(chosen.terms, target, fits)

    def _surprised(self, earlier: Polynomial, target: Array) -> bool:
        if self.newest.all():
            return True
        wrong = (target - earlier.evaluate(self.values)) ** 2
        return bool(np.sqrt(wrong[self.newest].mean()) > SURPRISE * np.sqrt(wrong[~self.newest].mean()))

    def _fitted(self, terms: Monomials, target: Array, fits: Callable[[Polynomial], bool]) -> Polynomial:
        columns, target = self.table.values.of(terms), self.windows.averaged(target)
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
