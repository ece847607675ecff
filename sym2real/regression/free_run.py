"""How well one equation runs on its own: its column from its own past, all other columns as they were measured.

Fitted row by row, an equation takes the noise of its own column for a part of what moves it, and its numbers become too
small (errors in variables). Fitted to runs whose starts are free they do not: that noise is then the output's alone
(output error method: L. Ljung, System Identification, 2nd ed., section 7.2). Noise of other columns stays in them.
"""

from collections.abc import Sequence

import numpy as np

from sym2real.dataset import Transitions
from sym2real.regression.features import Variables, tangent_scale
from sym2real.regression.polynomial import Polynomial
from sym2real.regression.windows import OVERLAP, Windows
from sym2real.trajectory import Array

DIVERGED = 1e30
STEPS = 10  # of Gauss and Newton
STILL = 1e-6  # relative fall of the loss that ends them
FAR_OFF = 3.0  # usual errors, from which on a run has less weight
NEAR = 1e-6  # of a column's spread, for derivatives


class FreeRuns:
    """Runs of one column, each of so many rows, beside the measured others.

    A component of a quaternion or a unit circle is put back on it after every step.

    Args:
        column: of the state.
        variables: what the terms are made of.
        transitions: rows that follow each other.
        rows: of a run.
    """

    def __init__(self, column: str, variables: Variables, transitions: Transitions, rows: int) -> None:
        layout = transitions.layouts.state
        field = next(field for field in layout.fields if column in field.columns)
        others = [] if field.kind == "vector" else [layout.index(other) for other in field.columns if other != column]
        place, starts = layout.index(column), Windows.of(transitions, rows).starts
        within = starts[:, None] + np.arange(rows)
        self.column, self.variables = column, variables
        self.start, self.measured = transitions.state[starts, place], transitions.next_state[within, place]
        self.values = np.moveaxis(variables.values_of(transitions)[within], 1, 0)
        self.beside = None
        if others:  # on the tangent that an equation's step ends on
            beside = transitions.next_state[:, others] * tangent_scale(transitions, field.columns)[:, None]
            self.beside = np.square(beside).sum(axis=1)[within]
        self.near = NEAR * (float(np.std(transitions.state[:, place])) or 1.0)

    def squares(self, added: Polynomial) -> Array:
        """Mean square error of every run from its best start, in the column's unit ``# (runs,)``; huge for no number.

        From measured starts an equation that soon forgets them would seem better than one that keeps their noise.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            run = self.run(added)
            errors = self._beside_start(added, run, (run - self.measured)[:, :, None])
            squares: Array = np.square(errors[:, :, 0]).mean(axis=1)
        return np.minimum(np.nan_to_num(squares, nan=DIVERGED, posinf=DIVERGED), DIVERGED)

    def run(self, added: Polynomial, beside: float = 0.0) -> Array:
        """The column along every run by what a step adds to it ``# (runs, rows)``; from so much beside its start."""
        state, states = self.start + beside, []
        for row, values in enumerate(self.values):
            state = self._on_manifold(state + added.evaluate(self._with(values, state)), row)
            states.append(state)
        return np.stack(states, axis=1)

    def fitted(self, added: Polynomial) -> Polynomial:
        """With the numbers that suit the runs best, wherever these start; as it is where runs diverge."""
        if not len(added):
            return added
        best, least, weights = added, np.inf, self._weights(added)
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(STEPS):
                errors, slopes = (part * weights[:, *[None] * (part.ndim - 1)] for part in self._linearised(added))
                errors, slopes = errors.ravel(), slopes.reshape(-1, len(added))
                loss = float(np.square(errors).sum())
                if not loss < least * (1.0 - STILL) or not np.isfinite(slopes).all():
                    break
                best, least = added, loss
                norms = np.maximum(np.linalg.norm(slopes, axis=0), np.finfo(float).tiny)
                step = np.linalg.lstsq(slopes / norms, -errors, rcond=None)[0] / norms
                added = Polynomial(added.terms, added.coefficients + step)
        return best

    def _linearised(self, added: Polynomial) -> tuple[Array, Array]:
        """Errors and their derivatives by the numbers, without what the start explains.

        ``# (runs, rows), (runs, rows, numbers)``
        """
        run, terms = self.run(added), added.terms
        size = np.sqrt(np.mean(np.square(terms.evaluate(np.concatenate(self.values))), axis=0))
        steps = np.diag(self.near / np.maximum(size, np.finfo(float).tiny))
        moved = [self.run(Polynomial(terms, added.coefficients + step)) for step in steps]
        slopes = [(other - run) / step.sum() for other, step in zip(moved, steps, strict=True)]
        both = self._beside_start(added, run, np.stack([run - self.measured, *slopes], axis=2))
        return both[:, :, 0], both[:, :, 1:]

    def _beside_start(self, added: Polynomial, run: Array, parts: Array) -> Array:
        """What of runs' parts ``# (runs, rows, k)`` another start does not explain."""
        along = self.run(added, self.near) - run
        along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
        beside: Array = parts - along[:, :, None] * np.einsum("rs,rsk->rk", along, parts)[:, None]
        return beside

    def _weights(self, added: Polynomial) -> Array:
        """Roots of Huber's weights of whole runs: a row that is far off is in few of them ``# (runs,)``."""
        size = np.sqrt(np.mean(np.square(self._linearised(added)[0]), axis=1))
        usual = FAR_OFF * np.median(size)
        return np.sqrt(np.where(size > usual, usual / np.maximum(size, np.finfo(float).tiny), 1.0))

    def _with(self, values: Array, state: Array) -> Array:
        """Values of the variables with this state of the column ``# (runs, variables)``."""
        now, variables = values.copy(), self.variables
        if self.column in variables.columns:
            now[:, variables.columns.index(self.column)] = state
        if self.column in variables.angles:
            sine = len(variables.columns) + variables.angles.index(self.column)
            now[:, sine], now[:, sine + len(variables.angles)] = np.sin(state), np.cos(state)
        return now

    def _on_manifold(self, state: Array, row: int) -> Array:
        if self.beside is None:
            return state
        unit: Array = state / np.sqrt(state**2 + self.beside[:, row])
        return unit


def plainest(models: Sequence[Polynomial], errors: Sequence[Array]) -> Polynomial:
    """That of fewest factors among those whose mean square error is the least, or higher by a standard error at most.

    The standard error is that of the difference, over runs that share no row (L. Breiman et al., Classification and
    Regression Trees, 1984, section 3.4.3).

    Args:
        models: what a step adds.
        errors: mean squares of every run by each ``# (runs,)``.
    """
    least = min(errors, key=lambda error: float(error.mean()))
    more = [error - least for error in errors]
    near = [terms for terms, by in zip(models, more, strict=True) if by.mean() <= by.std() / np.sqrt(len(by) / OVERLAP)]
    return min(near, key=lambda terms: int(terms.terms.powers.sum()))
