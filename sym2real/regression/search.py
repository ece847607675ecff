"""Beam search for the subset of candidate columns that explains a target best, on their Gram matrix alone.

A support S grows by the column that lowers the residual sum of squares most. With the Cholesky factor L of
G[S, S], rows W = L⁻¹ G[S, :], the residual correlations are r = c − Wᵀ L⁻¹ c[S] and the residual energies of the
columns d = diag G − Σ W²; adding column j lowers the sum by r_j² / d_j (Chen, Billings & Luo, "Orthogonal least
squares methods and their application to non-linear system identification", Int. J. Control 50, 1989).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dtrtrs

from sym2real.trajectory import Array

# A column whose energy outside the chosen columns' span is below this share is a combination of them.
DEPENDENT = 1e-9


@dataclass(frozen=True, eq=False)
class Support:
    """A set of chosen columns and what they leave unexplained.

    Args:
        columns: positions of the chosen columns, in the order of choice.
        rows: W ``# (chosen, candidates)``.
        correlation: r ``# (candidates,)``.
        energy: d ``# (candidates,)``.
        loss: residual sum of squares.
    """

    columns: tuple[int, ...]
    rows: Array
    correlation: Array
    energy: Array
    loss: float

    def gains(self) -> Array:
        """By how much each candidate would lower the loss; 0 for dependent ones ``# (candidates,)``."""
        free = self.energy > DEPENDENT
        gains = np.zeros_like(self.energy)
        np.divide(self.correlation**2, self.energy, out=gains, where=free)
        gains[list(self.columns)] = 0.0
        return gains

    def with_column(self, column: int, gram: Array) -> Support:
        """This support and one more column."""
        scale = 1.0 / np.sqrt(self.energy[column])
        row = (gram[column] - self.rows[:, column] @ self.rows) * scale
        weight = self.correlation[column] * scale
        return Support(
            (*self.columns, column),
            np.vstack([self.rows, row]),
            self.correlation - weight * row,
            self.energy - row**2,
            self.loss - weight**2,
        )


def empty_support(gram: Array, correlation: Array, energy: float) -> Support:
    """No column chosen: the loss is the target's energy."""
    return Support((), np.empty((0, len(gram))), correlation, np.diag(gram).copy(), energy)


def support_of(columns: tuple[int, ...], gram: Array, correlation: Array, energy: float) -> Support:
    """The support with these columns, factored at once."""
    if not columns:
        return empty_support(gram, correlation, energy)
    chosen = list(columns)
    own = gram[np.ix_(chosen, chosen)]
    try:
        factor = np.linalg.cholesky(own)
    except np.linalg.LinAlgError:  # columns that rounding makes dependent, as those of a log without noise
        factor = np.linalg.cholesky(own + DEPENDENT * np.eye(len(own)))
    both, _ = dtrtrs(factor, np.column_stack([gram[chosen], correlation[chosen]]), lower=1)
    rows, weights = both[:, :-1], both[:, -1]
    return Support(
        columns,
        rows,
        correlation - weights @ rows,
        np.diag(gram) - np.einsum("kc,kc->c", rows, rows),
        energy - float(weights @ weights),
    )


def without_each(support: Support, correlation: Array) -> tuple[Array, Array]:
    """Loss without each chosen column ``# (chosen,)``, and what each candidate then saves ``# (chosen, candidates)``.

    With P = G[S, S]⁻¹, weights w = P c[S] and B = P G[S, :], without column j the loss is larger by w_j²/P_jj, the
    residual correlations are r + B_j w_j/P_jj and the residual energies d + B_j²/P_jj.
    """
    chosen = list(support.columns)
    inverse, _ = dtrtrs(support.rows[:, chosen], np.eye(len(chosen)))  # of Lᵀ
    own, weights = np.square(inverse).sum(axis=1), inverse @ (inverse.T @ correlation[chosen])
    fitted = inverse @ support.rows
    left = support.correlation + (weights / own)[:, None] * fitted
    energy = support.energy + fitted**2 / own[:, None]
    gains = np.zeros_like(left)
    np.divide(left**2, energy, out=gains, where=energy > DEPENDENT)
    gains[:, chosen] *= np.eye(len(chosen))
    return support.loss + weights**2 / own, gains


def exchanged(support: Support, gram: Array, correlation: Array, energy: float) -> Support:
    """One exchange pass: every column is dropped in turn and the then best one put in its place."""
    losses, gains = without_each(support, correlation)
    for column in support.columns:
        place = support.columns.index(column)
        best = int(np.argmax(gains[place]))
        saved = gains[place, best]
        if best != column and losses[place] - saved < support.loss * (1 - 1e-9) and saved > 0:
            rest = tuple(other for other in support.columns if other != column)
            support = support_of(rest, gram, correlation, energy).with_column(best, gram)
            losses, gains = without_each(support, correlation)
    return support


def beam_search(
    gram: Array, correlation: Array, energy: float, *, width: int, branch: int, limit: int, together: bool = False
) -> list[tuple[int, ...]]:
    """The best set of columns found at every size from 0 to ``limit``.

    Args:
        gram: products of the candidate columns, with unit diagonal ``# (candidates, candidates)``.
        correlation: products of the candidates with the target ``# (candidates,)``.
        energy: product of the target with itself.
        width: supports kept at every size.
        branch: candidate columns for each of them.
        limit: size to stop at.
        together: look for columns that explain only together, too: begin with the first one, the constant where there
            is one, as well, and drop columns again from the largest set on, since such are found late, behind others
            that are needed no longer (floating search: P. Pudil, J. Novovičová, J. Kittler, "Floating search methods in
            feature selection", Pattern Recognition Letters 15, 1994).
    """
    beam = [empty_support(gram, correlation, energy)]
    supports: list[tuple[int, ...]] = [()]
    for _ in range(limit):
        children = _children(beam, branch)[:width]
        if not children:
            break
        beam = [beam[parent].with_column(column, gram) for _, parent, column in children]
        if together and len(supports) == 1:
            beam.append(support_of((0,), gram, correlation, energy))
        best = exchanged(beam[0], gram, correlation, energy)
        if best is not beam[0]:
            beam = [best, *beam[: width - 1]]
        supports.append(best.columns)
    return _backward(supports, gram, correlation, energy) if together else supports


def _backward(supports: list[tuple[int, ...]], gram: Array, correlation: Array, energy: float) -> list[tuple[int, ...]]:
    """At every size the better of these sets and of the next larger set without its least useful column."""

    better = list(supports)
    support = support_of(supports[-1], gram, correlation, energy)
    for size in range(len(supports) - 1, 0, -1):
        losses, _ = without_each(support, correlation)
        least, smaller = int(np.argmin(losses)), support_of(better[size - 1], gram, correlation, energy)
        if losses[least] < smaller.loss:
            better[size - 1] = (*support.columns[:least], *support.columns[least + 1 :])
            smaller = support_of(better[size - 1], gram, correlation, energy)
        support = smaller
    return better


def _children(beam: list[Support], branch: int) -> list[tuple[float, int, int]]:
    """(loss, parent, column) of every distinct support one column larger, best first."""
    seen: set[frozenset[int]] = set()
    children = []
    for parent, support in enumerate(beam):
        gains = support.gains()
        for column in np.argsort(-gains, kind="stable")[:branch].tolist():
            key = frozenset((*support.columns, column))
            if gains[column] > 0 and key not in seen:
                seen.add(key)
                children.append((support.loss - float(gains[column]), parent, column))
    return sorted(children)
