"""Disturbances, and what was found, as functions of something measured: shapes, and what each would change in a fit.

A term disturbs a channel by a constant and three powers of a feature's rank among the logs' values, ranks so that no
tail decides; or by what a command was a few rows ago less what it is, as any filter that acts on it would. The latter
says nothing of whole logs, and is taken less every log's mean: trim that differs from log to log has no part in it.
A channel is a disturbance, level forces in the robot's axes as well, or what a measurement is off by. It is also a
parameter that was found: of the right form it is the same everywhere, and no power of a rank is worth its place beside
it. J. Hausman, "Specification tests in econometrics", Econometrica 46 (1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sym2real.diagnosis.data.segments import summed
from sym2real.diagnosis.estimate.fit import Fit
from sym2real.diagnosis.estimate.significance import chance_of, clustered
from sym2real.diagnosis.estimate.whitening import PIECES, Spread, Whitening
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.unexplained.channels import Channel, offsets_of
from sym2real.diagnosis.unexplained.features import MOVES, ahead_of, features_of, means, within
from sym2real.least_squares import solve
from sym2real.trajectory import Array

CONSTANT = "constant"
# Rows by which a command is looked back at.
EARLIER = (1, 3, 9)
SMALLEST = 1e-12  # range of a feature, in its unit, that is rounding


@dataclass(frozen=True, eq=False)
class Feature:
    """Something that a channel may depend on.

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
            columns = zip(whole.T, np.sort(among.values.T), strict=True)  # none of the constant
            ranks = [np.interp(own, ordered, np.linspace(-1.0, 1.0, len(ordered))) for own, ordered in columns]
            powers = [rank**power for rank in ranks for power in (1, 2, 3)]
            whole = np.stack([np.ones(len(whole)), *powers], axis=1)
        return torch.as_tensor(whole).reshape(-1, PIECES, whole.shape[1])


def features_in(problem: Problem) -> tuple[dict[str, Feature], ...]:
    """Everything that a channel may depend on, by name, in pieces in the order of ``MOVES``."""
    names, moved = features_of(problem)
    here, *around = [{name: Feature(name, (name,), v[:, [place]]) for place, name in enumerate(names)} for v in moved]
    logs, dt = np.repeat(problem.segments.log, PIECES), problem.data.dt
    by_move = zip(*(_sent(problem, rows) for rows in (0, *EARLIER)), strict=True)
    for features, sent in zip((here, *around), by_move, strict=True):
        for column, action in enumerate(problem.data.layouts.action):
            words = tuple(f"{action} {k * dt:.2g} s earlier less {action}" for k in EARLIER)
            change = np.stack([earlier[:, column] - sent[0][:, column] for earlier in sent[1:]], axis=1)
            name = name_of_earlier(action)
            features[name] = Feature(name, words, within(change, logs), within=True)
    return {CONSTANT: Feature(CONSTANT, (), np.empty((len(logs), 0))), **here}, *around


def name_of_earlier(command: str) -> str:
    """The name of what a command was less what it is."""
    return f"earlier {command}"


def ranked(name: str) -> bool:
    """Whether terms of a feature are a constant and powers of its rank."""
    return name != CONSTANT and not name.startswith(name_of_earlier(""))


def _sent(problem: Problem, rows: int) -> tuple[Array, ...]:
    """Mean command so many rows earlier, over every piece, the one behind and the one before ``# (S·pieces, m)``."""
    columns = [np.pad(log.action, ((rows, 0), (0, 0)), mode="edge")[: len(log)] for log in problem.data]
    return tuple(means(problem, columns, move) for move in MOVES)


class Dependence(NamedTuple):
    """A channel that depends on a feature, of a piece so many moves on."""

    channel: Channel
    name: str
    move: int = 0

    @property
    def of_its_past(self) -> bool:
        """Whether a command depends on what it was."""
        return self.name == name_of_earlier(self.channel.name)


@dataclass(frozen=True, eq=False)
class Side:
    """A data set: the logs, or the plain simulator's.

    Args:
        columns: residuals at one parameter set, and their derivatives by those that are fitted ``# (S, R, 1 + A)``.
        spread: of the covariance.
        shapes: derivatives of the residuals, over every piece, by disturbances, by what measurements are off by, and by
            parameters that were found ``# (S, R, D, pieces)``.
        features: of the logs, whose ranks count, by name; others make no term.
        terms: shapes of terms by the feature's name ``# (S, pieces, K)``, in the order of ``MOVES``.
        ahead: where the robot points, level ``# (S, pieces, 2)``; None where nobody knows.
        problem: the data set with its segments.
    """

    columns: Tensor
    spread: Spread
    shapes: Tensor
    features: dict[str, Feature]
    terms: tuple[dict[str, Tensor], ...]
    ahead: Tensor | None
    problem: Problem

    @classmethod
    def of(
        cls, problem: Problem, spread: Spread, values: Tensor, fit: Fit, features: dict[str, Feature] | None = None
    ) -> Side:
        """At a parameter set ``# (P,)``.

        Args:
            problem: the data.
            spread: of it.
            values: the parameter set ``# (P,)``.
            fit: of what was found.
            features: of the logs; by default those of the data that vary, and the constant.
        """
        by_move = features_in(problem)
        if features is None:
            here = by_move[0].items()
            features = {name: own for name, own in here if name == CONSTANT or np.ptp(own.values) > SMALLEST}
        terms = tuple({n: own.shapes(features[n]) for n, own in moved.items() if n in features} for moved in by_move)
        (columns,) = problem.linearised(values[None], [fit.whole])
        slopes = columns[..., 1 : 1 + len(fit.free), None] / PIECES  # a step everywhere is one of all pieces
        measured = [place for *_, place in offsets_of(problem)]
        shape = torch.eye(len(problem.segments.compared), dtype=torch.float64)[:, measured] / PIECES
        offsets = shape.repeat(problem.segments.length, 1)[None, ..., None].expand(len(columns), -1, -1, PIECES)
        slopes = slopes.expand(*slopes.shape[:-1], PIECES)
        shapes = torch.cat([spread.disturbances, offsets, slopes], dim=2)
        return cls(columns, spread, shapes, features, terms, ahead_of(problem), problem)

    def products(self, whitening: Whitening) -> Tensor:
        """Products under C⁻¹, per segment, of all that terms are judged by ``# (S, 1 + A + D·pieces, ·)``.

        They are of the residual, its derivatives by the A parameters that are fitted, and every channel over every
        piece, with each other.
        """
        return whitening.products(torch.cat([self.columns, self.shapes.flatten(-2)], dim=-1))

    def has(self, term: Dependence) -> bool:
        """Whether its feature is known here."""
        return term.name in self.terms[term.move]

    def shapes_of(self, term: Dependence, before: Sequence[Dependence]) -> Tensor:
        """What it makes of its channel, by number of its own ``# (S, pieces, K)``.

        The constant belongs to the first term of a channel; that of a parameter is the parameter itself.
        """
        others = [own.name for own in before if own.channel == term.channel]
        known = term.channel.kind == "fitted" or any(name == CONSTANT or ranked(name) for name in others)
        shapes = self.terms[term.move][term.name]
        return shapes[..., 1:] if known and ranked(term.name) else shapes

    def basis(self, terms: Sequence[Dependence]) -> tuple[list[int], Tensor]:
        """Places of shapes, and what terms make of their pieces ``# (S, places·pieces, ΣK)``."""
        places = list(dict.fromkeys(place for term in terms for place in term.channel.places))
        columns = [self.columns.new_zeros(len(self.columns), len(places) * PIECES, 0)]
        for number, term in enumerate(terms):
            shapes = self.shapes_of(term, terms[:number])
            made = shapes.new_zeros(len(shapes), len(places), *shapes.shape[1:])
            for place, weight in zip(term.channel.places, self._weights(term.channel), strict=True):
                made[:, places.index(place)] = shapes * weight
            columns.append(made.flatten(1, 2))
        return places, torch.cat(columns, dim=-1)

    def _weights(self, channel: Channel) -> tuple[Tensor | float, ...]:
        """Of what a channel is made of ``# (S, pieces, 1)``."""
        if channel.axis is None or self.ahead is None:
            return (1.0,)
        x, y = self.ahead[..., :1], self.ahead[..., 1:]
        return (x, y) if channel.axis == 0 else (-y, x)

    def joined(self, products: Tensor, terms: Sequence[Dependence]) -> tuple[Tensor, Tensor]:
        """Half of the loss's derivatives by the parameters and terms ``# (S, A + ΣK), (S, A + ΣK, A + ΣK)``.

        Args:
            products: of :meth:`products`.
            terms: in their order.
        """
        fitted, (places, basis) = self.columns.shape[-1], self.basis(terms)
        pieces = [fitted + place * PIECES + piece for place in places for piece in range(PIECES)]
        across = products[:, :fitted, pieces] @ basis  # (S, 1 + A, ΣK)
        inside = basis.mT @ products[:, pieces][:, :, pieces] @ basis
        upper = torch.cat([products[:, :fitted, :fitted], across], dim=2)
        whole = torch.cat([upper, torch.cat([across.mT, inside], dim=2)], dim=1)
        return whole[:, 1:, 0], whole[:, 1:, 1:]

    def by_terms(self, terms: Sequence[Dependence]) -> Tensor:
        """Derivatives of the residuals by the numbers of terms ``# (S, R, ΣK)``."""
        places, basis = self.basis(terms)
        return self.shapes[:, :, places].flatten(-2) @ basis

    def after(self, terms: Sequence[Dependence], step: Tensor) -> Tensor:
        """Residuals after a step of the parameters and terms ``# (S, R)``."""
        return self.columns[..., 0] + torch.cat([self.columns[..., 1:], self.by_terms(terms)], dim=-1) @ step


@dataclass(frozen=True, eq=False)
class TermFit:
    """A term beside what was found and other terms, under one whitening.

    Args:
        terms: the others, and this one.
        preceding: number of parameters before the term's.
        gradient, curvature: half the loss's derivatives by parameters and terms, without what is the base's own
            ``# (S, A + ΣK), (S, A + ΣK, A + ΣK)``.
    """

    terms: tuple[Dependence, ...]
    preceding: int
    gradient: Tensor
    curvature: Tensor

    @property
    def term(self) -> Dependence:
        """Itself."""
        return self.terms[-1]

    @property
    def step(self) -> Tensor:
        """To the best parameters and terms ``# (A + ΣK,)``."""
        return solve(self.curvature.sum(0), -self.gradient.sum(0))

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
    step = solve(curvature.sum(0) - curvature, gradient - gradient.sum(0))
    return -float(2 * (gradient * step).sum() + torch.einsum("fa,fab,fb->", step, curvature, step))
