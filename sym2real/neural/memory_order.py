"""How much of the past a residual must see: the order of a finite impulse response, chosen by cross-validation.

What acts on the robot may be a sum over commands as they were sent, Σ_j h_j a_k-j, instead of the last of them: a
delay, a lag, a slow actuator. Then a base f that takes the command for what acts leaves, to first order::

    d_k = B_k Σ_j h_j (a_k-j - a_k-j+1) + what the present row says,   B_k = ∂f/∂a at row k

one number h_j for each lag and command, whatever the number of state columns, because B_k knows the way from a command
to the state. The order is the shortest whose error on blocks of time that took no part is within a standard error of
the least (:mod:`sym2real.neural.paired`). Source: L. Ljung, System Identification, 2nd ed., ch. 16 (order by validation
on fresh data).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from sym2real.dataset import Transitions
from sym2real.errors import ModelError
from sym2real.neural.leftover import Leftover, leftover
from sym2real.neural.multi_step import FLOOR
from sym2real.neural.paired import simplest
from sym2real.symbolic import Equations
from sym2real.trajectory import Array

LONGEST = 0.5  # s, of past commands: the longest delay among the effects
FOLDS, SHORTEST = 10, 10  # blocks of time, rows of a block
ROUNDING = 1e-5  # columns that differ by less are one: rows are in single precision


def memory_length(transitions: Transitions, base: Equations) -> int:
    """Number of past commands, as sent, that the next state depends on and a base does not know of.

    Where the base lacks much else that follows the commands, as in logs of a real car that never reached its speed
    command, the error falls to the longest order, which is then the answer.

    Args:
        transitions: of the target; commands must vary.
        base: frozen; where it has command filters, what counts is behind them.

    Raises:
        ModelError: for fewer than 100 transitions.
        ShapeError: for other columns than the base's.
    """
    if len(transitions) < FOLDS * SHORTEST:
        raise ModelError(f"an order needs at least {FOLDS * SHORTEST} transitions, found {len(transitions)}")
    longest = max(1, round(LONGEST / transitions.dt))
    rows = leftover(transitions, base, longest)
    errors = _held_out(_Series.of(rows, longest), [rows.driven.shape[-1] * (1 + count) for count in range(longest + 1)])
    return simplest([torch.as_tensor(column) for column in errors.T])


@dataclass(frozen=True, eq=False)
class _Series:
    """What is regressed on what; t tangent components, m commands.

    Args:
        error: d in units of its scale ``# (rows, t)``.
        effects: of commands on it, lag by lag from the present one ``# (rows, t, m·lags)``.
        present: one, state and command ``# (rows, 1 + n + m)``.
    """

    error: Array
    effects: Array
    present: Array

    @classmethod
    def of(cls, rows: Leftover, longest: int) -> _Series:
        """Those of a log."""
        size, actions = len(rows.layout), rows.driven.shape[-1]
        error, driven, seen = rows.error.double(), rows.driven.double(), rows.seen.double()
        present = np.concatenate([np.ones((len(rows), 1)), seen[:, : size + actions].numpy()], axis=1)
        sent = seen[:, size : size + actions * (1 + longest)].reshape(len(rows), 1 + longest, actions).numpy()
        moved = np.concatenate([sent[:, :1], np.diff(sent, axis=1)], axis=1)  # (rows, lags, m)
        scale = _scale(error.numpy(), present, rows.change.double().numpy())
        effects = (driven.numpy() / scale[:, None])[:, :, None, :] * moved[:, None]
        return cls(error.numpy() / scale, effects.reshape(len(rows), len(scale), -1), present)


def _scale(error: Array, present: Array, change: Array) -> Array:
    """Of each component: what the present row leaves of its error, and never less than rounding ``# (t,)``."""
    left = error - present @ np.linalg.lstsq(present, error, rcond=None)[0]
    floor: Array = FLOOR * np.sqrt(np.mean(change**2, axis=0)) + np.finfo(np.float32).tiny
    scale: Array = np.maximum(left.std(axis=0), floor)
    return scale


def _held_out(series: _Series, sizes: Sequence[int]) -> Array:
    """Mean squared error of each block of time by what the other blocks teach ``# (FOLDS, sizes)``.

    Args:
        series: the first so many columns of its effects share one coefficient each over all components.
        sizes: numbers of columns.
    """
    error, effects, present = series.error, series.effects, series.present
    fold = np.arange(len(error)) * FOLDS // len(error)
    present = present / (np.sqrt(np.mean(present**2, axis=0)) + np.finfo(np.float32).tiny)
    both = np.concatenate([effects, error[..., None]], axis=-1)
    errors = []
    for held in range(FOLDS):
        mine = fold != held
        taught = np.tensordot(np.linalg.pinv(present[mine], rcond=ROUNDING), both[mine], axes=1)
        left = both - np.tensordot(present, taught, axes=1)
        within, beyond = (_products(left[rows]) for rows in (mine, ~mine))
        errors.append([_error(within, beyond, size) for size in sizes])
    return np.array(errors)


def _products(columns: Array) -> Array:
    """Mean products of columns over rows and components ``# (columns, columns)``."""
    flat = columns.reshape(-1, columns.shape[-1])
    return flat.T @ flat / len(flat)


def _error(within: Array, beyond: Array, size: int) -> float:
    """Mean square that the first columns leave of the last one, by products where they are fitted and elsewhere."""
    weights = np.linalg.lstsq(within[:size, :size], within[:size, -1], rcond=None)[0]
    weights, kept = np.append(weights, -1.0), [*range(size), -1]
    return float(weights @ beyond[np.ix_(kept, kept)] @ weights)
