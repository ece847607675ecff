"""Candidate terms of the beam search: products of variables, built from each other by one multiplication."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from sym2real.trajectory import Array

Powers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Monomials:
    """Products of powers of variables, in order of degree.

    Args:
        powers: exponent of every variable in every product ``# (terms, variables)``.
    """

    powers: Powers

    @classmethod
    def to_degree(cls, variables: int, degree: int) -> Monomials:
        """Every product of at most ``degree`` of the variables, the constant 1 first."""
        rows = [
            np.bincount(chosen, minlength=variables) if chosen else np.zeros(variables, dtype=np.int64)
            for size in range(degree + 1)
            for chosen in combinations_with_replacement(range(variables), size)
        ]
        return cls(np.array(rows, dtype=np.int64).reshape(len(rows), variables))

    @classmethod
    def of(cls, terms: Iterable[Sequence[int]], variables: int) -> Monomials:
        """The products with these exponents, each once, in order of degree."""
        unique = sorted({tuple(int(power) for power in term) for term in terms}, key=lambda term: (sum(term), term))
        return cls(np.array(unique, dtype=np.int64).reshape(len(unique), variables))

    def __len__(self) -> int:
        return len(self.powers)

    @property
    def degrees(self) -> Powers:
        """Degree of every product ``# (terms,)``."""
        degrees: Powers = self.powers.sum(axis=1)
        return degrees

    def where(self, chosen: NDArray[np.bool_] | list[int]) -> Monomials:
        """The products at these positions, or where the mask holds."""
        index = np.array(chosen, dtype=np.int64) if isinstance(chosen, list) else chosen
        return Monomials(self.powers[index])

    def times(self, factors: Monomials) -> Monomials:
        """Every product multiplied by each of these factors, each result once."""
        variables = self.powers.shape[1]
        grown = self.powers[:, None, :] + factors.powers[None]
        return Monomials.of(grown.reshape(-1, variables).tolist(), variables)

    def without(self, others: Monomials, degree: int) -> Monomials:
        """The products to ``degree`` that are not among the others."""
        known = set(map(tuple, others.powers.tolist()))
        rows = [row for row in self.powers.tolist() if tuple(row) not in known and sum(row) <= degree]
        return Monomials.of(rows, self.powers.shape[1])

    def evaluate(self, values: Array) -> Array:
        """Values of the products ``# (rows, terms)`` for values of the variables ``# (rows, variables)``."""
        columns = np.empty((len(self), len(values)))
        known: dict[tuple[int, ...], Array] = {(0,) * values.shape[1]: np.ones(len(values))}
        for position, term in enumerate(self.powers.tolist()):
            columns[position] = known[tuple(term)] = _product(term, values, known)
        return np.ascontiguousarray(columns.T)


def _product(term: list[int], values: Array, known: dict[tuple[int, ...], Array]) -> Array:
    key = tuple(term)
    if key in known:
        return known[key]
    last = max(position for position, power in enumerate(term) if power)
    factor = list(term)
    factor[last] -= 1
    product: Array = _product(factor, values, known) * values[:, last]
    known[key] = product
    return product
