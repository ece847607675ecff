"""A pool of candidate terms, from which a few are chosen: their Gram matrix, and how many are worth it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from sym2real.regression.monomials import Monomials
from sym2real.regression.refit import refit
from sym2real.regression.search import beam_search
from sym2real.regression.windows import Mask, Values
from sym2real.trajectory import Array

# Validation errors below this share of the target's spread are rounding; they justify no further term.
FLOOR = 1e-9
# Noisy rows that a term needs at least.
ROWS_A_TERM = 4


@dataclass(frozen=True, eq=False)
class Choice:
    """Terms chosen for one target.

    Args:
        terms: the products.
        error: validation error, in units of the target.
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
        branch: candidate columns for each of them.
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
        """The best set of terms for a target ``# (rows,)`` whose spread is 1; ``noisy`` as a ``Stage`` says."""
        supports = _supports(self.columns, self.gram, target, settings, noisy=noisy)
        errors: Iterable[float] = (
            self._errors_of_size(target, settings)
            if noisy
            else (validation_error(self.columns[:, list(support)], target, self.held) for support in supports)
        )
        choices = []
        for support, error in zip(supports, errors, strict=False):  # a size that no half has is none that can be judged
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
