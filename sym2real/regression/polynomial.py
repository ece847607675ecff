"""Sums of products with numbers in front, to and from SymPy expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import NDArray

from sym2real.regression.features import Variables
from sym2real.regression.monomials import Monomials
from sym2real.symbolic import complexity, factor_horner, symbol
from sym2real.trajectory import Array


def generators(variables: Variables) -> list[sympy.Expr]:
    """The variables as SymPy expressions, in their order."""
    angles = [symbol(angle) for angle in variables.angles]
    columns = [symbol(column) for column in variables.columns]
    return [*columns, *map(sympy.sin, angles), *map(sympy.cos, angles), *map(symbol, variables.wrench)]


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Σ coefficient · product.

    Args:
        terms: the products.
        coefficients: one number each, in the units of the variables ``# (terms,)``.
    """

    terms: Monomials
    coefficients: Array

    def __len__(self) -> int:
        return len(self.terms)

    def __add__(self, other: Polynomial) -> Polynomial:
        powers = np.vstack([self.terms.powers, other.terms.powers])
        return Polynomial(Monomials(powers), np.concatenate([self.coefficients, other.coefficients]))

    def evaluate(self, values: Array) -> Array:
        """Values of the sum ``# (rows,)`` for values of the variables ``# (rows, variables)``."""
        return self.terms.evaluate(values) @ self.coefficients

    def where(self, chosen: NDArray[np.bool_]) -> Polynomial:
        """The terms where ``chosen`` holds."""
        return Polynomial(self.terms.where(chosen), self.coefficients[chosen])

    def expression(self, column: str, variables: Variables) -> sympy.Expr:
        """``column`` + this sum, factored so that it has few nodes."""
        return factor_horner(sympy.Add(symbol(column), *self._addends(generators(variables))))

    def increment(self, variables: Variables) -> sympy.Expr:
        """This sum, factored."""
        return factor_horner(sympy.Add(*self._addends(generators(variables))))

    def nodes(self, column: str, variables: Variables) -> int:
        """Nodes of :meth:`expression`."""
        return complexity(self.expression(column, variables))

    def _addends(self, factors: Sequence[sympy.Expr]) -> list[sympy.Expr]:
        return [
            sympy.Mul(sympy.Float(float(number)), *(factors[i] ** int(term[i]) for i in np.flatnonzero(term).tolist()))
            for number, term in zip(self.coefficients, self.terms.powers, strict=True)
        ]


def polynomial_of(expression: sympy.Expr, column: str, variables: Variables) -> Polynomial | None:
    """What an equation adds to its column, as a polynomial in the variables; None where it is none."""
    factors = generators(variables)
    stand_ins = {factor: sympy.Dummy(f"g{i}", real=True) for i, factor in enumerate(factors) if factor.args}
    gens = [stand_ins.get(factor, factor) for factor in factors]
    increment = (expression.doit() - symbol(column)).xreplace(stand_ins)
    try:
        polynomial = sympy.Poly(increment, *gens)
        numbers = np.array([float(number) for number in polynomial.coeffs()])
    except (sympy.PolynomialError, TypeError):
        return None
    keep = numbers != 0
    powers = np.array(polynomial.monoms(), dtype=np.int64).reshape(len(numbers), len(gens))
    return Polynomial(Monomials(powers[keep]), numbers[keep])
