"""Short sums of products for what a model leaves of each state column, from noisy rows.

What is left is averaged over windows of consecutive rows, and so is every candidate: the noise of a measured state
enters one row with one sign and the next with the other, and cancels, while what a model lacks adds up. (Prefiltering:
L. Ljung, System Identification, 2nd ed., section 14.4.) Terms are chosen as those of equations are from measured logs
(:class:`~sym2real.regression.stage.Stage`), and often there are none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from threadpoolctl import threadpool_limits

from sym2real.dataset import Transitions
from sym2real.errors import ModelError
from sym2real.regression.features import Variables
from sym2real.regression.selection import SearchSettings
from sym2real.regression.stage import Stage
from sym2real.trajectory import Array

FEWEST = 10  # windows: of two pieces of twice their length
# Of a state column's own change in a step: less than that is left alone, so that rounding gets no terms.
SMALL = 1e-3
# What no model knows yet is little: a term must pay more than one of a whole equation, of which there are five at most.
SEARCH = SearchSettings(width=4, branch=4, terms=5, parsimony=0.15, rounds=0)


@dataclass(frozen=True)
class ResidualSettings:
    """How terms are searched.

    Args:
        degree: of the candidates.
        window: rows that are averaged; 1 takes each by itself.
        search: of the beam search; terms do not grow.
        seed: which windows validate which.
    """

    degree: int = 3
    window: int = 20
    search: SearchSettings = SEARCH
    seed: int = 0


def residual_terms(
    transitions: Transitions, left: Array, settings: ResidualSettings, angles: Sequence[str] = ()
) -> dict[str, sympy.Expr]:
    """State column → sum of products that predicts what is left of it; columns without are missing.

    Args:
        transitions: states and actions that the terms are made of.
        left: of the next state ``# (rows, n)``.
        settings: of the search.
        angles: columns in rad whose sine and cosine may stand in terms.

    Raises:
        ModelError: for fewer than ten windows of consecutive rows.
    """
    variables, increments = Variables.of(transitions.layouts, angles), {}
    with threadpool_limits(limits=1, user_api="blas"):  # small matrices: threads cost more than they gain
        stage = Stage(
            transitions,
            variables,
            variables.products(settings.degree),
            search=settings.search,
            loss="l2",
            seed=settings.seed,
            window=settings.window,
            noisy=True,
        )
        if (windows := len(stage.windows.starts)) < FEWEST:
            wanted = f"at least {FEWEST} windows of {settings.window} consecutive transitions"
            raise ModelError(f"terms of a residual need {wanted}, found {windows}")
        change = transitions.next_state - transitions.state
        sizes = np.sqrt(np.mean(left**2, axis=0)), np.sqrt(np.mean(change**2, axis=0))
        for column, target, size, moved in zip(transitions.layouts.state, left.T, *sizes, strict=True):
            if size > SMALL * moved and len(terms := stage.solve(column, target, None, lambda _: True)):
                increments[column] = terms.increment(variables)
    return increments
