"""One table of candidate terms, searched for many targets: split, Gram matrix, choice of size, growth."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sym2real.regression.monomials import Monomials
from sym2real.regression.search import beam_search
from sym2real.trajectory import Transitions

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BLOCK = 20
# Validation errors below this share of the target's spread are rounding; they justify no further term.
FLOOR = 1e-9


def validation_rows(transitions: Transitions, seed: int) -> Mask:
    """Every other block of 20 steps ``# (rows,)``; the parity of ``seed`` says which ones.

    Neighbouring rows are nearly alike, so whole blocks are held back. A table shorter than two blocks is split row
    by row.
    """
    block = transitions.step // BLOCK + transitions.trajectory
    if len(np.unique(block % 2)) < 2:
        block = np.arange(len(transitions))
    held: Mask = (block + seed) % 2 == 1
    return held


@dataclass(frozen=True, eq=False)
class Choice:
    """Terms chosen for one target.

    Args:
        terms: the products.
        error: root mean square validation error, in the unit of the target.
        score: what the choice was made by; lower is better.
    """

    terms: Monomials
    error: float
    score: float


@dataclass(frozen=True)
class SearchSettings:
    """How the search goes.

    Args:
        width: supports kept at every size.
        branch: columns tried on each of them.
        terms: most terms in an equation.
        parsimony: what a term of degree 3 must lower ln(validation error) by.
        growth: degree that chosen terms are multiplied up to.
    """

    width: int = 8
    branch: int = 6
    terms: int = 14
    parsimony: float = 0.1
    growth: int = 4


@dataclass(frozen=True, eq=False)
class Pool:
    """Candidates with their values and the Gram matrix of the training rows.

    Args:
        terms: the candidates.
        columns: their values ``# (rows, candidates)``.
        norms: norms over the training rows ``# (candidates,)``.
        gram: products of the normed columns over the training rows ``# (candidates, candidates)``.
        held: which rows validate ``# (rows,)``.
    """

    terms: Monomials
    columns: Array
    norms: Array
    gram: Array
    held: Mask

    @classmethod
    def of(cls, terms: Monomials, values: Array, held: Mask) -> Pool:
        """Candidates that are not zero on the training rows."""
        columns = terms.evaluate(values)
        norms = np.linalg.norm(columns[~held], axis=0)
        alive = norms > 1e-12 * norms.max(initial=0.0)
        terms, columns, norms = terms.where(alive), columns[:, alive], norms[alive]
        normed = columns[~held] / norms
        return cls(terms, columns, norms, normed.T @ normed, held)

    def grown(self, terms: Monomials, values: Array) -> Pool:
        """This pool and further candidates."""
        more = Pool.of(terms, values, self.held)
        across = (self.columns[~self.held] / self.norms).T @ (more.columns[~self.held] / more.norms)
        return Pool(
            Monomials(np.vstack([self.terms.powers, more.terms.powers])),
            np.hstack([self.columns, more.columns]),
            np.concatenate([self.norms, more.norms]),
            np.block([[self.gram, across], [across.T, more.gram]]),
            self.held,
        )

    def choose(self, target: Array, settings: SearchSettings) -> Choice:
        """The best set of terms for a target ``# (rows,)`` whose spread is 1."""
        train, held = target[~self.held], target[self.held]
        correlation = self.columns[~self.held].T @ train / self.norms
        found = beam_search(
            self.gram,
            correlation,
            float(train @ train),
            width=settings.width,
            branch=settings.branch,
            limit=settings.terms,
        )
        choices = [self._judged(list(support), train, held, settings.parsimony) for support in found]
        return min(choices, key=lambda choice: choice.score)

    def _judged(self, support: list[int], train: Array, held: Array, parsimony: float) -> Choice:
        terms, columns = self.terms.where(support), self.columns[:, support] / self.norms[support]
        coefficients = np.linalg.lstsq(columns[~self.held], train, rcond=None)[0]
        error = float(np.sqrt(np.mean((held - columns[self.held] @ coefficients) ** 2)))
        return Choice(terms, error, score(error, terms, parsimony))


def score(error: float, terms: Monomials, parsimony: float) -> float:
    """ln(validation error) + parsimony · Σ max(1, degree) / 3; lower is better."""
    return float(np.log(max(error, FLOOR)) + parsimony * np.maximum(1, terms.degrees).sum() / 3)


class Table:
    """Rows, candidates and their split, for the targets of one kind of equation.

    Args:
        values: scaled values of the variables ``# (rows, variables)``.
        candidates: the products to choose from.
        signs: sign pattern of products' powers (see ``Variables.signs``).
        multipliers: positions of the variables that chosen terms may be multiplied by.
        held: rows that validate ``# (rows,)``.
    """

    def __init__(
        self,
        values: Array,
        candidates: Monomials,
        *,
        signs: Callable[[NDArray[np.int64]], NDArray[np.int64]],
        multipliers: Iterable[int],
        held: Mask,
        settings: SearchSettings,
    ) -> None:
        self.values, self.candidates, self.signs = values, candidates, signs
        self.multipliers, self.held, self.settings = list(multipliers), held, settings
        self._pools: dict[bytes, Pool] = {}

    def _of_sign(self, terms: Monomials, sign: NDArray[np.int64]) -> Monomials:
        return terms.where((self.signs(terms.powers) == sign).all(axis=1))

    def pool(self, sign: NDArray[np.int64]) -> Pool:
        """The candidates with this sign pattern; built once."""
        key = sign.tobytes()
        if key not in self._pools:
            self._pools[key] = Pool.of(self._of_sign(self.candidates, sign), self.values, self.held)
        return self._pools[key]

    def choose(self, target: Array, sign: NDArray[np.int64]) -> Choice:
        """Terms for a target ``# (rows,)``, grown by multiplying what was chosen first."""
        spread = float(target.std())
        if spread <= 1e-14 * float(np.abs(target).max(initial=0.0)) or spread == 0.0:
            spread = 1.0
        pool = self.pool(sign)
        choice = pool.choose(target / spread, self.settings)
        grown = self._of_sign(choice.terms.times(self.multipliers), sign)
        fresh = grown.without(pool.terms, self.settings.growth)
        if len(fresh):
            choice = min(
                choice,
                pool.grown(fresh, self.values).choose(target / spread, self.settings),
                key=lambda one: one.score,
            )
        return Choice(choice.terms, choice.error * spread, choice.score)
