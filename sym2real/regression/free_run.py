"""How well one equation runs on its own: its column from its own past, all other columns as they were measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sym2real.dataset import Transitions
from sym2real.regression.features import Variables
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.windows import Windows
from sym2real.trajectory import Array

DIVERGED = 1e30
# Times the least mean square: equations that noise alone tells apart differ by less.
NEARLY = 1.1


def plainest(found: Sequence[Polynomial], errors: Sequence[Array]) -> Polynomial:
    """That of fewest factors among those whose mean square error is nearly the least.

    Args:
        found: what a step adds.
        errors: mean squares of every run by each ``# (runs,)``.
    """
    means = [float(error.mean()) for error in errors]
    near = [terms for terms, mean in zip(found, means, strict=True) if mean <= NEARLY * min(means)]
    return min(near, key=lambda terms: int(terms.terms.powers.sum()))


def free_runs(added: Polynomial, column: str, variables: Variables, transitions: Transitions, rows: int) -> Array:
    """Mean square error of every run of so many rows, in the column's unit ``# (runs,)``; huge where one diverges.

    A component of a quaternion or a unit circle is put back on it after every step, beside the measured others.

    Args:
        added: what a step adds to the column.
        column: of the state.
        variables: what the terms are made of.
        transitions: rows that follow each other.
        rows: of a run.
    """
    layout = transitions.layouts.state
    field = next(field for field in layout.fields if column in field.columns)
    others = [] if field.kind == "vector" else [layout.index(other) for other in field.columns if other != column]
    values, starts = variables.values_of(transitions), Windows.of(transitions, rows).starts
    own, place = [name == column for name in variables.columns], layout.index(column)
    state, squares = transitions.state[starts, place], np.zeros(len(starts))
    with np.errstate(over="ignore", invalid="ignore"):
        for row in range(rows):
            now = values[starts + row]
            now[:, np.flatnonzero(own)] = state[:, None]
            if column in variables.angles:
                sine = len(variables.columns) + variables.angles.index(column)
                now[:, sine], now[:, sine + len(variables.angles)] = np.sin(state), np.cos(state)
            state = state + added.evaluate(now)
            measured = transitions.next_state[starts + row]
            if others:
                state = state / np.sqrt(state**2 + np.square(measured[:, others]).sum(axis=1))
            squares += np.square(state - measured[:, place]) / rows
    return np.minimum(np.nan_to_num(squares, nan=DIVERGED, posinf=DIVERGED), DIVERGED)
