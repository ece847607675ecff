"""Equations of one time step, gone through again and again until the next row of a log that is slower than they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from math import ceil

import numpy as np
from numpy.typing import NDArray
from sympy import Add, Expr, Float, Max, Mul, Pow, Rational

from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import exchange, symbol
from sym2real.symbolic.source import TIME

# Part of a step by which a period may miss a whole number of them and be that number: a log's stamps are rounded.
WHOLE = 0.01
# States between which the last row is interpolated; a cubic leaves 1e-4 of a decay that halves in a step.
NODES = 4
SMALLEST_NORM = 1e-12


def at_period(equations: Equations, period: float) -> Equations:
    """The equations over a longer period, commands and inputs held: what they say after each of their own steps.

    A period between two steps lies on the polynomial through the last :data:`NODES` states. Filters of commands keep
    their values; they act on rows, which are a period apart.

    Args:
        equations: with their own step; they come back as they are where the period is no longer.
        period: in s.
    """
    steps = round(period / equations.dt, 3)
    return equations if steps <= 1.0 + WHOLE else _gone_through(equations, steps)


@lru_cache(maxsize=16)
def _gone_through(equations: Equations, steps: float) -> Equations:
    count = round(steps) if abs(steps - round(steps)) <= WHOLE else ceil(steps)
    columns = equations.layouts.state.columns
    quantities, states = dict(equations.quantities), [{column: symbol(column) for column in columns}]
    for number in range(count):
        named, following = _step(equations, number, states[-1])
        quantities |= named
        states.append(following)
    nodes = np.arange(count + 1)[-NODES:]
    weights = _weights(nodes, count if count == round(steps) else steps)
    after = {
        column: Add(*(Float(w) * states[node][column] for node, w in zip(nodes, weights, strict=True) if w))
        for column in columns
    }
    return replace(equations, next=after, quantities=quantities, dt=steps * equations.dt)


def _step(equations: Equations, number: int, state: Mapping[str, Expr]) -> tuple[dict[str, Expr], dict[str, Expr]]:
    """Quantities of one more step from a state, and the names of the state that it leads to."""
    own = {symbol(name): symbol(f"{name}__{number}") for name in equations.quantities} if number else {}
    time = {symbol(TIME): symbol(TIME) + number * equations.dt} if TIME in equations.layouts.inputs else {}
    put_in = exchange({**{symbol(column): value for column, value in state.items()}, **own, **time})
    named = {f"{name}__{number}": put_in(value) for name, value in equations.quantities.items()} if number else {}
    moved = {column: symbol(f"{column}__{number + 1}") for column in state}
    norms: dict[str, Expr] = {}
    for field in equations.layouts.state.fields:
        if field.kind != "vector":
            squares = Add(*(Pow(put_in(equations.next[column]), 2) for column in field.columns))
            norms |= dict.fromkeys(field.columns, Max(Pow(squares, Rational(1, 2)), SMALLEST_NORM))
    for column, following in moved.items():
        after = put_in(equations.next[column])
        named[following.name] = Mul(after, Pow(norms[column], -1)) if column in norms else after
    return named, moved


def _weights(nodes: NDArray[np.int64], place: float) -> NDArray[np.float64]:
    """Of the values at whole places, in that of their polynomial at ``place`` # (nodes,)."""
    apart = nodes[:, None] - nodes + np.eye(len(nodes))
    others = np.where(np.eye(len(nodes), dtype=bool), 1.0, (place - nodes)[None, :] / apart)
    found: NDArray[np.float64] = others.prod(axis=1)
    return found
