"""A term of its own for what no effect explains: a polynomial in what it depends on, unverified.

Its coefficients are fitted by generalised least squares on the whitened residuals, and it is scored on logs left out.
"""

from dataclasses import dataclass, replace

import numpy as np
import sympy
import torch

from sym2real.dataset import Dataset
from sym2real.diagnosis.data.segments import cut, folds_of
from sym2real.diagnosis.estimate.whitening import Whitening, disturbances
from sym2real.diagnosis.predict.library import Library
from sym2real.diagnosis.predict.sensitivity import Problem
from sym2real.diagnosis.settings import SETTINGS
from sym2real.diagnosis.unexplained.disturbance_terms import CONSTANT, TermFit, features_in
from sym2real.diagnosis.unexplained.leftover import Leftover
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


def propose(informed: Equations, data: Dataset, leftover: Leftover, whitening: Whitening) -> Term | None:
    """The term that explains most of what is left in a channel; None where none saves as much as an
    effect must of what it has not seen.

    Args:
        informed: the equations with every finding in them.
        data: the logs that the rest is of.
        leftover: what is left.
        whitening: of the residuals.
    """
    sizes, bare = dict(disturbances(informed)), replace(informed, filters=())
    variable = sympy.Integer(1) if leftover.explained_by == CONSTANT else nameable(informed).get(leftover.explained_by)
    # A measurement that is off is no disturbance; a change, an angle's lag are no quantities that the equations hold.
    if leftover.channel not in sizes or variable is None:
        return None
    logs = with_filtered_commands(informed, data)
    problem = _of(bare, logs, whitening)
    feature, monomials = features_in(problem)[0].get(leftover.explained_by), [sympy.Float(sizes[leftover.channel])]
    if feature is None:  # a command that a limit which was found holds
        return None
    if feature.columns:
        largest = float(np.abs(feature.values).max())
        monomials = [monomials[0] * (variable / largest) ** power for power in range(DEGREE + 1)]
    terms = [add_term(bare, leftover.channel, text(canonical(monomial))) for monomial in monomials]
    before, *after = (_of(own, logs, whitening).residuals(problem.library.null[None])[0] for own in (bare, *terms))
    products = whitening.products(torch.stack([before, *(changed - before for changed in after)], dim=-1))
    fit = TermFit((), 0, products[:, 1:, 0], products[:, 1:, 1:])
    gain = fit.fall(folds_of(problem.segments)) / float(products[:, 0, 0].sum())
    exact = canonical(sympy.Add(*(step * own for step, own in zip(fit.step.tolist(), monomials, strict=True))))
    rounded = {atom: sympy.Float(float(f"{float(atom):.{DIGITS}g}")) for atom in exact.atoms(sympy.Float)}
    return Term(leftover.channel, text(exact.xreplace(rounded)), gain) if gain > SETTINGS.gain else None


def _of(equations: Equations, logs: Dataset, whitening: Whitening) -> Problem:
    return Problem(Library.of(equations, []), logs, cut(logs, whitening.fields, whitening.length))
