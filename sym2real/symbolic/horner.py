"""Factoring a sum of monomials so that it has few nodes: greedy multivariate Horner with a short look-ahead.

At each step one factor that stands in most terms (or one number that is the coefficient of several) is taken out:
``sum → factor·(terms that had it) + rest``; among the most frequent ones the cheapest result is kept.
M. Ceberio, V. Kreinovich: "Greedy algorithms for optimizing multivariate Horner schemes" (2004).
"""

from collections import Counter

import sympy
from sympy import Expr

from sym2real.symbolic.expressions import product

WIDTH = 3  # candidate factors at each step
Key = tuple[str, int | float]  # ("factor", position of the generator) or ("number", coefficient)
Monomial = tuple[float, tuple[int, ...]]  # coefficient, sorted positions of its generators, one per power
Terms = tuple[Monomial, ...]


def factor_horner(expression: Expr) -> Expr:
    """An equal expression with as few nodes as the greedy search finds; anything but a sum is returned as it is.

    Exact in the coefficients: they are moved, never multiplied. Compiler and node count take the result as written.
    """
    if not expression.is_Add:
        return expression
    generators: dict[Expr, int] = {}
    numbers: dict[float, Expr] = {}
    terms = tuple(_monomial(term, generators, numbers) for term in expression.args)
    scheme = _Scheme(list(generators), numbers)
    scheme.cost(terms)
    return scheme.build(terms)


def _monomial(term: Expr, generators: dict[Expr, int], numbers: dict[float, Expr]) -> Monomial:
    coefficient, rest = term.as_coeff_Mul()
    numbers[float(coefficient)] = coefficient
    numbers.setdefault(-float(coefficient), -coefficient)
    positions = list[int]()
    for factor in sympy.Mul.make_args(rest):
        base, exponent = factor.as_base_exp()
        if not (exponent.is_Integer and exponent.is_positive):
            base, exponent = factor, 1
        if base is not sympy.S.One:
            positions += [generators.setdefault(base, len(generators))] * int(exponent)
    return (float(coefficient), tuple(sorted(positions)))


class _Scheme:
    """Cheapest factoring found of every set of terms that came up."""

    def __init__(self, generators: list[Expr], numbers: dict[float, Expr]) -> None:
        self.generators = generators
        self.numbers = {**numbers, 1.0: sympy.S.One, -1.0: sympy.S.NegativeOne}
        self.best: dict[Terms, tuple[int, Key | None]] = {}

    def cost(self, terms: Terms) -> int:
        """Nodes of the sum of these terms; generators count as 1."""
        if terms not in self.best:
            candidates: list[tuple[int, Key | None]] = [(_flat_cost(terms), None)]
            for key in self._frequent(terms):
                inner, rest = _split(terms, key)
                candidates.append((2 + self.cost(inner) + (1 + self.cost(rest) if rest else 0), key))
            self.best[terms] = min(candidates, key=lambda pair: pair[0])
        return self.best[terms][0]

    def _frequent(self, terms: Terms) -> list[Key]:
        counts: Counter[Key] = Counter()
        for coefficient, positions in terms:
            counts.update(("factor", position) for position in set(positions))
            if abs(coefficient) != 1.0 and positions:
                counts["number", abs(coefficient)] += 1
        return [key for key, times in counts.most_common(WIDTH) if times > 1]

    def build(self, terms: Terms) -> Expr:
        key = self.best[terms][1]
        if key is None:
            return sympy.Add(*(self._term(term) for term in terms))
        inner, rest = _split(terms, key)
        factor = self.generators[int(key[1])] if key[0] == "factor" else self.numbers[key[1]]
        factored = product([factor, self.build(inner)])
        return sympy.Add(factored, self.build(rest)) if rest else factored

    def _term(self, term: Monomial) -> Expr:
        coefficient, positions = term
        return product([self.numbers[coefficient], *(self.generators[position] for position in positions)])


def _flat_cost(terms: Terms) -> int:
    cost = len(terms) - 1 + (2 if all(coefficient == -1.0 for coefficient, _ in terms) else 0)
    for coefficient, positions in terms:
        cost += max(2 * len(positions) - 1, 1) + (2 if abs(coefficient) != 1.0 and positions else 0)
    return cost


def _split(terms: Terms, key: Key) -> tuple[Terms, Terms]:
    """Terms that hold the key, divided by it, and the others."""
    inner, rest = list[Monomial](), list[Monomial]()
    for coefficient, positions in terms:
        if key[0] == "number" and abs(coefficient) == key[1] and positions:
            inner.append((coefficient / abs(coefficient), positions))
        elif key[0] == "factor" and key[1] in positions:
            place = positions.index(int(key[1]))
            inner.append((coefficient, positions[:place] + positions[place + 1 :]))
        else:
            rest.append((coefficient, positions))
    return tuple(inner), tuple(rest)
