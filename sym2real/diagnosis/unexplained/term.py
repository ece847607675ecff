"""A term of its own for what no effect explains: proposed by regression, scored on logs left out, unverified.

The disturbance that residuals still ask for is regressed on a polynomial in what it depends on. Most likely
disturbances are shrunk towards zero, so the polynomial is then scaled by least squares on the whitened residuals
themselves, which also give its held-out gain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy
import torch
from numpy.polynomial import Polynomial
from sympy import Expr

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import cut, folds_of, summed
from sym2real.diagnosis.estimate.whitening import Whitening
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.features import TURNED
from sym2real.diagnosis.unexplained.leftover import Leftover, Rest
from sym2real.effects.along_logs import with_filtered_commands
from sym2real.effects.written_term import add_term, nameable
from sym2real.symbolic import Equations
from sym2real.symbolic.expressions import canonical, text

DEGREE = 2  # the lowest that can be even in a variable, or odd
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


def propose(informed: Equations, data: Dataset, rest: Rest, leftover: Leftover, whitening: Whitening) -> Term | None:
    """The term that explains most of what is left in a channel; None where none saves as much as an
    effect must of what it has not seen.

    Args:
        informed: the equations with every finding in them.
        data: the logs that the rest is of.
        rest: what is left.
        leftover: what it depends on, or its size where it is constant.
        whitening: of the residuals.
    """
    channel = leftover.channel
    if channel not in rest.names or channel.endswith(TURNED):  # a measurement that is off is no disturbance
        return None
    if leftover.size is None:
        variable = nameable(informed).get(leftover.explained_by)
        if variable is None:  # a change, an angle's lag: no quantity that the equations hold
            return None
        values = rest.values[:, rest.features.index(leftover.explained_by)]
        target = rest.disturbances[:, rest.names.index(channel)]
        coefficients = Polynomial.fit(values, target, DEGREE).convert().coef
        expression = sympy.Add(*(float(factor) * variable**power for power, factor in enumerate(coefficients)))
    else:
        expression = sympy.Float(leftover.size)
    scale, gain = _scaled(informed, data, channel, expression, whitening)
    exact = canonical(expression * scale)
    rounded = {atom: sympy.Float(float(f"{float(atom):.{DIGITS}g}")) for atom in exact.atoms(sympy.Float)}
    return Term(channel, text(exact.xreplace(rounded)), gain) if gain > SETTINGS.gain else None


def _scaled(
    informed: Equations, data: Dataset, channel: str, expression: Expr, whitening: Whitening
) -> tuple[float, float]:
    """Best factor of the term, and its relative gain on groups that took no part in the factor."""
    logs, residuals = with_filtered_commands(informed, data), []
    bare = replace(informed, filters=())
    for equations in (bare, add_term(bare, channel, text(canonical(expression)))):
        problem = Problem(Library.of(equations, []), logs, cut(logs, whitening.fields))
        residuals.append(problem.residuals(torch.zeros(1, 0, dtype=torch.float64))[0])
    before, change = residuals[0], residuals[1] - residuals[0]
    products = whitening.products(torch.stack([before, change], dim=-1))  # (S, 2, 2)
    sums = summed(products, folds_of(problem.segments))
    whole = sums.sum(0)
    factors = -(whole - sums)[:, 0, 1] / (whole - sums)[:, 1, 1].clamp_min(1e-300)
    left = sums[:, 0, 0] + 2 * factors * sums[:, 0, 1] + factors**2 * sums[:, 1, 1]
    return float(-whole[0, 1] / whole[1, 1].clamp_min(1e-300)), float(1.0 - left.sum() / whole[0, 0])
