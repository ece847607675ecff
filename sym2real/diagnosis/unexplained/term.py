"""A term of its own for what no effect explains: proposed by sparse regression, scored on logs left out, unverified.

The disturbances that residuals still ask for are regressed on monomials up to degree two of what the equations know,
one monomial after the other, while grouped cross-validation gains. Most likely disturbances are shrunk towards zero, so
the sum is then scaled by least squares on the whitened residuals themselves, which also give its held-out gain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
import sympy
import torch
from numpy.typing import NDArray
from sympy import Expr

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.preparation import with_filtered_commands
from sym2real.diagnosis.estimate.whitening import Whitening
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.leftover import Leftover, Rest
from sym2real.effects.body import Body
from sym2real.effects.clock import with_time
from sym2real.effects.frames import body_velocity
from sym2real.effects.inputs import TIME
from sym2real.effects.noted import TERM
from sym2real.effects.wrench import with_force_inputs
from sym2real.errors import ModelError, UnknownNameError
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import canonical, text
from sym2real.symbolic.parsing import parse_expression
from sym2real.trajectory import Array
from sym2real.vocabulary import FORCE, HEIGHT, VELOCITY

MOST_MONOMIALS = 3
DIGITS = 4


@dataclass(frozen=True)
class Term:
    """A disturbance that the library has no name for.

    Args:
        channel: input or command that it is added to.
        expression: in the channel's unit, over columns of the equations and time ``t``.
        gain: relative fall of the whitened loss on groups that took no part in its scale.
    """

    channel: str
    expression: str
    gain: float

    def apply(self, equations: Equations) -> Equations:
        """The equations with the term in them."""
        return add_term(equations, self.channel, self.expression)


def add_term(equations: Equations, channel: str, expression: str) -> Equations:
    """The equations with an expression added to an input or command, wherever it stands; to a force, where they can.

    Raises:
        UnknownNameError: for a channel or a name that the equations do not have.
        ModelError: for text that is not an expression.
    """
    equations = with_force_inputs(equations) if channel in FORCE.columns else equations
    known = (*equations.layouts.inputs, *equations.layouts.action)
    if channel not in known:
        raise UnknownNameError("input or command of the model", channel, known)
    try:
        parsed = parse_expression(expression)
    except ModelError as error:
        raise ModelError(f"term of {channel}: {error}") from error
    if any(symbol.name == TIME for symbol in parsed.free_symbols):
        equations, _ = with_time(equations)
    changed = equations.substitute({channel: symbol(channel) + parsed})
    note = f"unverified: the term {expression} in {channel}"
    return replace(changed, notes=(*changed.notes, note), effects=(*changed.effects, (f"{TERM}{channel}", {})))


def propose(informed: Equations, data: Dataset, rest: Rest, leftover: Leftover, whitening: Whitening) -> Term | None:
    """The term that explains most of what is left in a channel; None where none gains on what it has not seen.

    Args:
        informed: the equations with every finding in them.
        data: the logs that the rest is of.
        rest: what is left.
        leftover: what it depends on, or its size where it is constant.
        whitening: weighs the residuals.
    """
    channel = leftover.channel
    if channel not in rest.names:  # a measurement that is off is no disturbance
        return None
    known = {name: value for name, value in _symbols(informed).items() if name in rest.features}
    columns = {value: rest.values[:, rest.features.index(name)] for name, value in known.items()}
    if leftover.size is None:
        found = _regressed(columns, rest.disturbances[:, rest.names.index(channel)], rest.groups)
    else:
        found = sympy.Float(leftover.size)
    if found is None:
        return None
    scale, gain = _scaled(informed, data, channel, found, whitening)
    rounded = canonical(found * scale)
    short = {atom: sympy.Float(float(f"{float(atom):.{DIGITS}g}")) for atom in rounded.atoms(sympy.Float)}
    rounded = rounded.xreplace(short)
    return Term(channel, text(rounded), gain) if gain > 0.0 else None


def _symbols(equations: Equations) -> dict[str, Expr]:
    """Features of the leftover as expressions over the equations' columns."""
    names, body = {*equations.layouts.state, *equations.layouts.action}, Body.of(equations)
    found: dict[str, Expr] = {name: symbol(name) for name in sorted(names)}
    found |= {"time": symbol(TIME)} | ({"height": symbol(HEIGHT)} if HEIGHT in names else {})
    along = [name for name in VELOCITY.columns if name in names]
    if along:
        found |= {f"velocity {axis}": symbol(name) for axis, name in zip("xyz", along, strict=False)}
        if equations.layouts.state.has_field("attitude"):
            found |= {f"body velocity {axis}": value for axis, value in zip("xyz", body_velocity(body), strict=True)}
        elif equations.layouts.state.has_field("heading"):
            found["forward speed"] = body_velocity(body)[0]
    return found


def _regressed(columns: dict[Expr, Array], target: Array, groups: NDArray[np.int64]) -> Expr | None:
    """Sum of few monomials with coefficients, less its mean."""
    bases = [(*pair,) for count in (1, 2) for pair in combinations_with_replacement(columns, count)]
    values = {base: np.prod([columns[factor] for factor in base], axis=0) for base in bases}
    chosen: list[tuple[Expr, ...]] = []
    reached = 0.0
    while len(chosen) < MOST_MONOMIALS:
        scored = [(_unseen_r2([values[factor] for factor in (*chosen, base)], target, groups), base) for base in bases]
        best, base = max(scored, key=lambda factor: factor[0])
        if best < reached + SETTINGS.one_more:
            break
        chosen, reached = [*chosen, base], best
    if not chosen:
        return None
    design = np.column_stack([*(values[factor] for factor in chosen), np.ones(len(target))])
    coefficients = np.linalg.lstsq(design, target, rcond=None)[0]
    return sympy.Add(
        *(float(c) * sympy.Mul(*factor) for c, factor in zip(coefficients, chosen, strict=False)),
        float(coefficients[-1]),
    )


def _unseen_r2(columns: list[Array], target: Array, groups: NDArray[np.int64]) -> float:
    design = np.column_stack([*columns, np.ones(len(target))])
    predicted = np.empty_like(target)
    for group in np.unique(groups):
        unseen = groups == group
        solution = np.linalg.lstsq(design[~unseen], target[~unseen], rcond=None)[0]
        predicted[unseen] = design[unseen] @ solution
    return float(1.0 - np.square(target - predicted).sum() / max(np.square(target - target.mean()).sum(), 1e-300))


def _scaled(
    informed: Equations, data: Dataset, channel: str, expression: Expr, whitening: Whitening
) -> tuple[float, float]:
    """Best factor of the term, and its relative gain on groups that took no part in the factor."""
    logs, residuals = with_filtered_commands(informed, data), []
    bare = replace(informed, filters=())
    for equations in (bare, add_term(bare, channel, text(canonical(expression)))):
        problem = Problem(Library.of(equations, []), logs)
        residuals.append(problem.residuals(torch.zeros(1, 0, dtype=torch.float64))[0])
    before, change = residuals[0], residuals[1] - residuals[0]
    products = whitening.products(torch.stack([before, change], dim=-1))  # (S, 2, 2)
    fold = _folds(problem)
    sums = np.stack([products[torch.as_tensor(fold == part)].sum(0).numpy() for part in np.unique(fold)])
    whole = sums.sum(0)
    factors = -(whole - sums)[:, 0, 1] / np.maximum((whole - sums)[:, 1, 1], 1e-300)
    left = sums[:, 0, 0] + 2 * factors * sums[:, 0, 1] + factors**2 * sums[:, 1, 1]
    return float(-whole[0, 1] / max(whole[1, 1], 1e-300)), float(1.0 - left.sum() / whole[0, 0])


def _folds(problem: Problem) -> NDArray[np.int64]:
    """Logs, or quarters of a single one."""
    log = problem.segments.log
    return log if len(np.unique(log)) > 1 else (np.arange(len(log)) * 4 // len(log)).astype(np.int64)
