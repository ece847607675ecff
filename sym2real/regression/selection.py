"""One table of candidate terms, searched for many targets: split, Gram matrix, choice of size, growth."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from sym2real.regression.monomials import Monomials, Powers
from sym2real.regression.refit import refit
from sym2real.regression.search import beam_search
from sym2real.regression.windows import Mask, Values
from sym2real.trajectory import Array

# Validation errors below this share of the target's spread are rounding; they justify no further term.
FLOOR = 1e-9
# Rows further off than so many median errors weigh less in the second choice.
FAR_OFF = 3.0
# Noisy rows that a term needs at least.
ROWS_A_TERM = 4
# No row weighs less: the few rows that leave the calm region are what shows the terms that act there.
LEAST_WEIGHT = 0.03


@dataclass(frozen=True, eq=False)
class Choice:
    """Terms chosen for one target.

    Args:
        terms: the products.
        error: validation error, in the unit of the target.
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
        parsimony: what a term of degree 3 must lower ln(validation error) by, at least (see :func:`score`).
        growth: degree that chosen terms are multiplied up to.
        rounds: how often they are, as long as that lowers the score.
    """

    width: int = 8
    branch: int = 6
    terms: int = 14
    parsimony: float = 0.07
    growth: int = 4
    rounds: int = 3


def validation_error(columns: Array, target: Array, held: Mask) -> float:
    """Error on rows that coefficients were not fitted to: geometric mean of both halves' root mean squares.

    The geometric mean, because one half may hold the only wild rows and its error would drown the other's.
    """
    logarithms = []
    for other in (held, ~held):
        coefficients = refit(columns[~other], target[~other], "l2")
        logarithms.append(np.log(np.mean((target[other] - columns[other] @ coefficients) ** 2) + np.finfo(float).tiny))
    return float(np.exp(np.mean(logarithms) / 2))


def score(error: float, terms: Monomials, parsimony: float, *, honest: bool = False) -> float:
    """ln(validation error) + demand · Σ max(1, degree) / 3; lower is better.

    The demand is ``parsimony`` where a thousandth or less of the target's spread is left, and rises to three times
    that where a tenth is: then something acts that no term can give (wheel slip, noise), and terms that seem to
    help are chance more often.

    Args:
        error: validation error as a share of the target's spread.
        terms: the products.
        parsimony: demand per term of degree 3.
        honest: the terms were chosen without the rows of the error, so that chance does not help them.
    """
    error = max(error, FLOOR)
    demand = parsimony * (1.0 if honest else float(np.clip(np.log10(error) + 4.0, 1.0, 3.0)))
    return float(np.log(error) + demand * np.maximum(1, terms.degrees).sum() / 3)


@dataclass(frozen=True, eq=False)
class Pool:
    """Candidates with their values and Gram matrix.

    Args:
        terms: the candidates.
        columns: their values, each column of norm 1 ``# (rows, candidates)``.
        gram: products of the columns ``# (candidates, candidates)``.
        held: the half of the rows that validates the other ``# (rows,)``.
    """

    terms: Monomials
    columns: Array
    gram: Array
    held: Mask

    @classmethod
    def of(cls, terms: Monomials, values: Values, weights: Array, held: Mask) -> Pool:
        """Candidates that are not zero everywhere; ``weights`` multiply the rows ``# (rows,)``."""
        columns = values.of(terms) * weights[:, None]
        norms = np.linalg.norm(columns, axis=0)
        alive = norms > 1e-12 * norms.max(initial=0.0)
        columns = columns[:, alive] / norms[alive]
        return cls(terms.where(alive), columns, columns.T @ columns, held)

    def grown(self, terms: Monomials, values: Values, weights: Array) -> Pool:
        """This pool and further candidates."""
        more = Pool.of(terms, values, weights, self.held)
        across = self.columns.T @ more.columns
        return Pool(
            Monomials(np.vstack([self.terms.powers, more.terms.powers])),
            np.hstack([self.columns, more.columns]),
            np.block([[self.gram, across], [across.T, more.gram]]),
            self.held,
        )

    def choose(self, target: Array, settings: SearchSettings, *, noisy: bool) -> Choice:
        """The best set of terms for a target ``# (rows,)`` whose spread is 1; ``noisy`` as a :class:`Table` says."""
        found = _supports(self.columns, self.gram, target, settings, noisy=noisy)
        errors: Iterable[float] = (
            self._errors_of_size(target, settings)
            if noisy
            else (validation_error(self.columns[:, list(support)], target, self.held) for support in found)
        )
        choices = []
        for support, error in zip(found, errors, strict=False):  # a size that no half has is none that can be judged
            terms = self.terms.where(list(support))
            choices.append(Choice(terms, error, score(error, terms, settings.parsimony, honest=noisy)))
        return min(choices, key=lambda choice: choice.score)

    def _errors_of_size(self, target: Array, settings: SearchSettings) -> list[float]:
        """Validation error by number of terms, the terms too chosen without the rows that validate them.

        The best of some hundred candidates fits noise of all rows, and so of those that were held back.
        """
        logarithms = []
        for fitted in (~self.held, self.held):
            columns, own, other = self.columns[fitted], target[fitted], target[~fitted]
            norms = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
            columns = columns / norms
            unseen = self.columns[~fitted] / norms
            supports = map(list, _supports(columns, columns.T @ columns, own, settings, noisy=True))
            left = (other - unseen[:, chosen] @ refit(columns[:, chosen], own, "l2") for chosen in supports)
            logarithms.append([np.log(np.mean(wrong**2) + np.finfo(float).tiny) for wrong in left])
        return [float(np.exp(np.mean(both) / 2)) for both in zip(*logarithms, strict=False)]


def _supports(
    columns: Array, gram: Array, target: Array, settings: SearchSettings, *, noisy: bool
) -> list[tuple[int, ...]]:
    return beam_search(
        gram,
        columns.T @ target,
        float(target @ target),
        width=settings.width,
        branch=settings.branch,
        # More terms than that nobody can tell from noise, and some of them depend on the others.
        limit=min(settings.terms, len(target) // ROWS_A_TERM) if noisy else settings.terms,
        together=noisy,
    )


class Table:
    """Rows, candidates and their split, for the targets of one kind of equation.

    Args:
        values: scaled values of the variables.
        candidates: the products to choose from.
        signs: sign pattern of products' powers (see ``Variables.signs``).
        multipliers: products that chosen terms may be multiplied by.
        held: the half of the rows that validates the other ``# (rows,)``.
        noisy: where rows are, terms that explain only together are looked for too, as noise hides them one by one, and
            their number is judged by windows that begin among rows which had no part in choosing them.
    """

    def __init__(
        self,
        values: Values,
        candidates: Monomials,
        *,
        signs: Callable[[Powers], Powers],
        multipliers: Monomials,
        held: Mask,
        settings: SearchSettings,
        noisy: bool = False,
    ) -> None:
        self.values, self.candidates, self.signs = values, candidates, signs
        self.multipliers, self.held, self.settings, self.noisy = multipliers, held, settings, noisy
        self._pools: dict[bytes, Pool] = {}

    def _of_sign(self, terms: Monomials, sign: Powers) -> Monomials:
        return terms.where((self.signs(terms.powers) == sign).all(axis=1))

    def _pool(self, sign: Powers) -> Pool:
        """The candidates with this sign pattern, rows of equal weight; built once."""
        key = sign.tobytes()
        if key not in self._pools:
            terms, weights = self._of_sign(self.candidates, sign), np.ones(len(self.values))
            self._pools[key] = Pool.of(terms, self.values, weights, self.held)
        return self._pools[key]

    def choose(self, target: Array, sign: Powers) -> Choice:
        """Terms for a target ``# (rows,)``.

        Chosen twice: rows that the first choice leaves far off weigh less in the second (Huber's weights), so that a
        few rows of another regime, such as wheels that slip, do not hide what the many obey.
        """
        spread = float(target.std())
        if spread <= 1e-14 * float(np.abs(target).max(initial=0.0)) or spread == 0.0:
            spread = 1.0
        target, pool = target / spread, self._pool(sign)
        choice = self._grown(pool, target, np.ones(len(target)), sign)
        if choice.error > FLOOR:
            columns = self.values.of(choice.terms)
            wrong = np.abs(target - columns @ refit(columns, target, "l1"))
            share = FAR_OFF * np.median(wrong) / np.maximum(wrong, np.finfo(float).tiny)
            weights = np.sqrt(np.clip(share, LEAST_WEIGHT, 1.0))
            weighted = Pool.of(pool.terms, self.values, weights, self.held)
            choice = self._grown(weighted, target * weights, weights, sign)
        return Choice(choice.terms, choice.error * spread, choice.score)

    def _grown(self, pool: Pool, target: Array, weights: Array, sign: Powers) -> Choice:
        """Terms for a weighted target: what is chosen is multiplied by further factors and chosen from again."""
        choice = pool.choose(target, self.settings, noisy=self.noisy)
        for _ in range(self.settings.rounds):
            fresh = self._of_sign(choice.terms.times(self.multipliers), sign).without(pool.terms, self.settings.growth)
            if not len(fresh):
                break
            pool = pool.grown(fresh, self.values, weights)
            better = pool.choose(target, self.settings, noisy=self.noisy)
            if better.score >= choice.score:
                break
            choice = better
        return choice
