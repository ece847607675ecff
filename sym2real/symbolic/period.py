"""Equations of one time step, gone through again and again until the next row of a log that is slower than they are."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from sympy import Add, Expr, Max, Mul, Pow, Rational

from sym2real.errors import ModelError
from sym2real.layout import Layout, Layouts
from sym2real.symbolic.equations import Equations
from sym2real.symbolic.expressions import exchange, symbol
from sym2real.symbolic.source import TIME

# Part of a step by which a period may miss a whole number of them and be that number; ratios are rounded to as much.
WHOLE = 1e-3
MOST = 20  # steps; stamps in another unit than s would make thousands
SMALLEST_NORM = 1e-12


def steps_within(equations: Equations, period: float) -> int:
    """Equal parts of a period, none shorter than the equations' own step; one where the period is no longer."""
    return max(1, int(round(_ratio(equations, period) + WHOLE, 6)))


def at_period(equations: Equations, period: float, *, apart: bool = False) -> Equations:
    """The equations over a longer period, in equal parts as long as their own step or somewhat longer.

    A part that is longer ends on the parabola through the states at its start and after one and two steps. Filters of
    commands keep their values.

    Args:
        equations: with their own step; they come back as they are where the period is no longer.
        period: in s.
        apart: whether the commands of every part are columns of their own, all of the first part before those of the
            second, and not held over the period.

    Raises:
        ModelError: for a period of more than :data:`MOST` steps.
    """
    ratio = _ratio(equations, period)
    if not ratio <= MOST + 0.5:
        raise ModelError(
            f"expected rows at most {MOST} of the model's steps of {equations.dt:g} s apart, found {period:g} s "
            "(is the unit of the stamps right?)"
        )
    return equations if ratio <= 1.0 + WHOLE else _gone_through(equations, ratio, apart)


def _ratio(equations: Equations, period: float) -> float:
    return round(period / equations.dt, 3)


@lru_cache(maxsize=16)
def _gone_through(equations: Equations, ratio: float, apart: bool) -> Equations:
    parts = steps_within(equations, ratio * equations.dt)
    way = _Way(equations, apart)
    for number in range(parts):
        way.part(number, ratio / parts)
    layouts = replace(equations.layouts, action=_each_part(equations.layouts, parts)) if apart else equations.layouts
    return replace(equations, next=way.state, quantities=way.quantities, layouts=layouts, dt=ratio * equations.dt)


def _each_part(layouts: Layouts, parts: int) -> Layout:
    fields = layouts.action.fields
    others = [
        replace(field, name=_at(field.name, number), columns=tuple(_at(column, number) for column in field.columns))
        for number in range(1, parts)
        for field in fields
    ]
    return Layout((*fields, *others))


def _at(name: str, number: int | str) -> str:
    return f"{name}__{number}"


class _Way:
    """The state after some parts of a period, by names of quantities that lead there.

    Args:
        equations: of one step.
        apart: as of :func:`at_period`.
    """

    def __init__(self, equations: Equations, apart: bool) -> None:
        self._equations, self._apart = equations, apart
        self.quantities: dict[str, Expr] = dict(equations.quantities)
        self.state: dict[str, Expr] = {column: symbol(column) for column in equations.layouts.state}

    def part(self, number: int, steps: float) -> None:
        """Go on by a part that is as long as so many steps, between one and two."""
        start, after = self.state, self._step(number, self.state, str(number), number * steps)
        if abs(steps - 1.0) <= WHOLE:
            self.state = after
            return
        nodes = start, after, self._step(number, after, f"{number}_more", number * steps + 1.0)
        weights = (1.0 - steps) * (2.0 - steps) / 2.0, steps * (2.0 - steps), steps * (steps - 1.0) / 2.0
        reached = {c: Add(*(w * node[c] for w, node in zip(weights, nodes, strict=True))) for c in start}
        self.state = self._named(self._normalised(reached), f"{number}_end")

    def _step(self, number: int, state: Mapping[str, Expr], label: str, before: float) -> dict[str, Expr]:
        equations, first = self._equations, label == "0"
        put_in = {symbol(column): value for column, value in state.items()}
        if TIME in equations.layouts.inputs:
            put_in[symbol(TIME)] = symbol(TIME) + before * equations.dt
        if self._apart and number:
            put_in |= {symbol(column): symbol(_at(column, number)) for column in equations.layouts.action}
        if not first:
            put_in |= {symbol(name): symbol(_at(name, label)) for name in equations.quantities}
            self._named({name: exchange(put_in)(value) for name, value in equations.quantities.items()}, label)
        after = {column: exchange(put_in)(following) for column, following in equations.next.items()}
        return self._named(self._normalised(after), f"after_{label}")

    def _named(self, values: Mapping[str, Expr], label: str) -> dict[str, Expr]:
        self.quantities |= {_at(name, label): value for name, value in values.items()}
        return {name: symbol(_at(name, label)) for name in values}

    def _normalised(self, state: dict[str, Expr]) -> dict[str, Expr]:
        for field in self._equations.layouts.state.fields:
            if field.kind != "vector":
                squares = Add(*(Pow(state[column], 2) for column in field.columns))
                inverse = Pow(Max(Pow(squares, Rational(1, 2)), SMALLEST_NORM), -1)
                state |= {column: Mul(state[column], inverse) for column in field.columns}
        return state
