"""Disturbances, and what was found, as functions of something measured: shapes, and what each would change in a fit.

A term disturbs a channel by a constant and three powers of a feature's rank among the logs' values, ranks so that no
tail decides; or by what a command was a few rows ago less what it is, as any filter that acts on it would. The latter
says nothing of whole logs, and is taken less every log's mean: trim that differs from log to log has no part in it.
A channel is also a parameter that was found: of the right form it is the same everywhere, and no power of a rank is
worth its place beside it. J. Hausman, "Specification tests in econometrics", Econometrica 46 (1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.estimate.quadratic import Fit, solve
from sym2real.diagnosis.estimate.significance import chance_of, clustered, inflation
from sym2real.diagnosis.estimate.whitening import PIECES, Spread, Whitening
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.unexplained.features import features_of, within
from sym2real.trajectory import Array

CONSTANT = "constant"
# Rows by which a command is looked back at.
EARLIER = (1, 3, 9)
SMALLEST = 1e-12


@dataclass(frozen=True, eq=False)
class Feature:
    """Something that a disturbance may depend on.

    Args:
        name: in words.
        columns: names of its columns; none for the constant.
        values: means over every piece ``# (S·pieces, columns)``.
        within: whether it varies within logs alone.
    """

    name: str
    columns: tuple[str, ...]
    values: Array
    within: bool = False

    def shapes(self, among: Feature) -> Tensor:
        """Shapes of its term ``# (S, pieces, K)``, ranks being those among the values of another data set."""
        whole = self.values
        if not self.within:
            rank = np.empty((len(whole), 0))
            if self.columns:
                ordered = np.sort(among.values[:, 0])
                rank = np.interp(whole, ordered, np.linspace(-1.0, 1.0, len(ordered)))
            whole = np.concatenate([np.ones((len(whole), 1)), rank, rank**2, rank**3], axis=1)
        return torch.as_tensor(whole).reshape(-1, PIECES, whole.shape[1])


def features_in(problem: Problem) -> dict[str, Feature]:
    """Everything that a disturbance may depend on, by name."""
    names, (_, values, _) = features_of(problem)
    measured = {name: Feature(name, (name,), values[:, [place]]) for place, name in enumerate(names)}
    dt, sent = problem.data.dt, _sent(problem, (0, *EARLIER))
    for column, name in enumerate(problem.data.layouts.action):
        words = tuple(f"{name} {k * dt:.2g} s earlier less {name}" for k in EARLIER)
        change = within((sent[1:, :, column] - sent[0, :, column]).T, np.repeat(problem.segments.log, PIECES))
        measured[name_of_earlier(name)] = Feature(name_of_earlier(name), words, change, within=True)
    varying = {name: feature for name, feature in measured.items() if np.ptp(feature.values) > SMALLEST}
    return {CONSTANT: Feature(CONSTANT, (), np.empty((len(values), 0))), **varying}


def name_of_earlier(command: str) -> str:
    """The name of what a command was less what it is."""
    return f"earlier {command}"


def _sent(problem: Problem, earlier: Sequence[int]) -> Array:
    """Mean command over every piece, so many rows earlier ``# (len(earlier), S·pieces, m)``."""
    segments = problem.segments
    edges = segments.edges(PIECES)
    # Of all rows before each, so that the sum over any piece is a difference.
    sums = [np.pad(log.action.cumsum(0), ((1, 0), (0, 0))) for log in problem.data]
    back, count = np.array(earlier)[:, None], np.diff(edges)[:, None]
    places = zip(segments.log, segments.row, strict=True)
    return np.concatenate([np.diff(sums[log][row + edges - back], axis=1) / count for log, row in places], axis=1)


@dataclass(frozen=True, eq=False)
class Side:
    """A data set: the logs, or the plain simulator's.

    Args:
        columns: residuals at one parameter set, and their derivatives by those that are fitted ``# (S, R, 1 + A)``.
        spread: of the covariance.
        shapes: derivatives of the residuals by every channel over every piece: disturbances, then parameters that were
            found ``# (S, R, D, pieces)``.
        terms: shapes of every term, by the feature's name ``# (S, pieces, K)``.
        logs: name of every segment's log.
    """

    columns: Tensor
    spread: Spread
    shapes: Tensor
    terms: dict[str, Tensor]
    logs: tuple[str, ...]

    @classmethod
    def of(cls, problem: Problem, spread: Spread, values: Tensor, fit: Fit, among: dict[str, Feature]) -> Side:
        """At a parameter set ``# (P,)``.

        Args:
            problem: the data.
            spread: of it.
            values: the parameter set ``# (P,)``.
            fit: of what was found.
            among: features of the logs, whose ranks count.
        """
        (columns,) = problem.linearised(values[None], [fit.whole])
        slopes = columns[..., 1 : 1 + len(fit.free), None] / PIECES  # a step everywhere is one of all pieces
        shapes = torch.cat([spread.disturbances, slopes.expand(*slopes.shape[:-1], PIECES)], dim=2)
        here = features_in(problem)
        terms = {name: here[name].shapes(feature) for name, feature in among.items() if name in here}
        return cls(columns, spread, shapes, terms, problem.log_names)

    def products(self, whitening: Whitening) -> Tensor:
        """Products under C⁻¹, per segment, of all that terms are judged by ``# (S, 1 + A + D·pieces, ·)``.

        They are of the residual, its derivatives by the A parameters that are fitted, and every channel over every
        piece, with each other.
        """
        return whitening.products(torch.cat([self.columns, self.shapes.flatten(-2)], dim=-1))

    def term(self, channel: int, name: str) -> Tensor:
        """Shapes of a term ``# (S, pieces, K)``; of a parameter without the constant, which is the parameter itself."""
        return self.terms[name] if channel < len(self.spread.names) else self.terms[name][..., 1:]

    def joined(self, products: Tensor, channel: int, name: str) -> tuple[Tensor, Tensor]:
        """Half of the loss's derivatives by the parameters and a term's ``# (S, A + K), (S, A + K, A + K)``.

        Args:
            products: of :meth:`products`.
            channel: its number.
            name: of the feature.
        """
        term, fitted = self.term(channel, name), slice(0, self.columns.shape[-1])
        first = fitted.stop + channel * PIECES
        pieces = slice(first, first + PIECES)
        across = products[:, fitted, pieces] @ term  # (S, 1 + A, K)
        inside = term.mT @ products[:, pieces, pieces] @ term
        upper = torch.cat([products[:, fitted, fitted], across], dim=2)
        whole = torch.cat([upper, torch.cat([across.mT, inside], dim=2)], dim=1)
        return whole[:, 1:, 0], whole[:, 1:, 1:]

    def after(self, channel: int, name: str, step: Tensor) -> Tensor:
        """Residuals after a step of the parameters and a term ``# (S, R)``."""
        shapes = self.shapes[:, :, channel] @ self.term(channel, name)  # (S, R, K)
        return self.columns[..., 0] + torch.cat([self.columns[..., 1:], shapes], dim=-1) @ step


@dataclass(frozen=True, eq=False)
class TermFit:
    """A term beside what was found, under one whitening.

    Args:
        channel, name: number of what varies, and the feature it depends on.
        preceding: number of parameters before the term's.
        gradient, curvature: half the loss's derivatives by parameters and term, without what is the base's own
            ``# (S, A + K), (S, A + K, A + K)``.
    """

    channel: int
    name: str
    preceding: int
    gradient: Tensor
    curvature: Tensor

    @property
    def step(self) -> Tensor:
        """To the best parameters and term ``# (A + K,)``."""
        return solve(self.curvature.sum(0), -self.gradient.sum(0))

    @property
    def inflation(self) -> float:
        """Times as wide as alone the interval of its last number is beside what was found."""
        return float(inflation(self.curvature.sum(0))[-1])

    @property
    def most(self) -> float:
        """Fall of the loss by the term that is fitted to it."""
        gradient, curvature, n = self.gradient.sum(0), self.curvature.sum(0), self.preceding
        before = float(gradient[:n] @ solve(curvature[:n, :n], gradient[:n])) if n else 0.0
        return float(gradient @ solve(curvature, gradient)) - before

    def fall(self, folds: NDArray[np.int64]) -> float:
        """Fall of the held-out loss by the term."""
        gradient, curvature = summed(self.gradient, folds), summed(self.curvature, folds)
        before = _saved(gradient[:, : self.preceding], curvature[:, : self.preceding, : self.preceding])
        return _saved(gradient, curvature) - before

    def chance(self, clusters: NDArray[np.int64]) -> float:
        """Probability that the term is this far from none by chance."""
        step, term = self.step, slice(self.preceding, None)
        spread = clustered(self.gradient + self.curvature @ step, self.curvature, clusters)
        return chance_of(step[term], spread[term, term], len(np.unique(clusters[clusters >= 0])))


def _saved(gradient: Tensor, curvature: Tensor) -> float:
    """Fall of quadratic losses ``# (folds, A), (folds, A, A)``, each at the best of the others."""
    others = curvature.sum(0) - curvature
    step = solve(others, gradient - gradient.sum(0))
    return -float(2 * (gradient * step).sum() + torch.einsum("fa,fab,fb->", step, curvature, step))
