"""One control period of equations of motion by the classical Runge–Kutta method, in as many parts as the robot needs.

A servo of the rate may brake within a fraction of a period; a step that is long beside that swings up.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from sympy import Expr, Rational, count_ops

from sym2real.robots.spatial import Values
from sym2real.symbolic import symbol
from sym2real.symbolic.dry_friction import dry_friction
from sym2real.trajectory import Array

Known = tuple[Values, Values]

# Decay in a part of a period; Runge–Kutta steps swing up beyond 2.8, and a joint may brake twice as much as described.
DECAY = 1.4
STAGES = (Rational(1, 2), Rational(1, 2), 1)  # parts of the period behind which the rates are asked again
SWEEPS = 2  # of friction by friction, each beside the others' last (Gauss–Seidel)
LONGEST = 4  # operations of an expression that needs no name

_show = ContextVar[Callable[[str], object]]("is told what is being derived", default=str)


@contextmanager
def telling(show: Callable[[str], object]) -> Iterator[None]:
    """Inside, ``show`` is told what is being derived: steps of many joints take seconds each."""
    before = _show.set(show)
    try:
        yield
    finally:
        _show.reset(before)


@dataclass
class Build:
    """Equations in the making: intermediate results by name, those of one evaluation with one prefix.

    Args:
        quantities: what has a name.
        dt: control period in s.
        parts: steps in it.
        prefix: of the evaluation.
    """

    quantities: dict[str, Expr]
    dt: float
    parts: int
    prefix: str = ""

    @property
    def part(self) -> float:
        """Length of a step in s."""
        return self.dt / self.parts

    def name(self, name: str, expression: Expr) -> Expr:
        """A name for an expression."""
        self.quantities[self.prefix + name] = expression
        return symbol(self.prefix + name)

    def short(self, name: str, expression: Expr) -> Expr:
        """The expression, or a name for it where it is long."""
        return self.name(name, expression) if is_long(expression) else expression

    def each(self, name: str, values: Values) -> Values:
        """An array of expressions, each short; the numbers of entries are part of their names."""
        shortened = np.empty_like(values, dtype=object)
        for place in np.ndindex(values.shape):
            shortened[place] = self.short(f"{name}_{'_'.join(map(str, place))}", values[place])
        return shortened


def is_long(expression: Expr) -> bool:
    """Whether it takes more than :data:`LONGEST` operations.

    They are counted where a walk through the tree does not say so by far: SymPy counts slowly. It counts more than a
    third of what the tree has: x - y has a sum and a product.
    """
    waiting, operations = [expression], 0
    while waiting and operations <= 3 * LONGEST:
        arguments = getattr(waiting.pop(), "args", ())  # numbers of Python have none
        operations += max(len(arguments) - 1, 1) if arguments else 0
        waiting += arguments
    return operations > 3 * LONGEST or count_ops(expression) > LONGEST


def fastest(inertia: Array, brakes: Array) -> float:
    """Fastest decay of rates in 1/s that are braked by so much ``# (n, n)``, of what has this inertia ``# (n, n)``."""
    return float(np.linalg.eigvals(np.linalg.solve(inertia, brakes)).real.max())


def parts_of(decay: float, dt: float) -> int:
    """Runge–Kutta steps in a period, by how fast rates decay (1/s)."""
    return max(1, math.ceil(decay * dt / DECAY))


class Mechanism(Protocol):
    """Equations of motion, in three steps."""

    def known(self, place: Values, rate: Values) -> Known:
        """What coordinates and rates say ``# (n,)``."""

    def friction(self, known: Known, rate: Values) -> tuple[Values, Values]:
        """Dry friction, its mean over a part that starts like this, and what coordinates are off by then ``# (n,)``."""

    def accelerations(self, known: Known, friction: Values) -> Values:
        """Of the coordinates ``# (n,)``, with that friction."""


def stepped(build: Build, mechanism: Mechanism, place: Values, rate: Values) -> tuple[Values, Values]:
    """Change of coordinates over a period, and the rates behind it."""
    moved, start = 0, place
    for part in range(build.parts):
        _show.get()(f"deriving the equations of {len(place)} joints: step {part + 1} of {build.parts} in a period")
        build.prefix = f"part{part + 1}_" if part else ""
        if part:
            place, rate = build.each("place", start + moved), build.each("rate", rate)
        further, gained = _step(build, mechanism, place, rate)
        moved, rate = moved + further, rate + gained
    return moved, rate


def _step(build: Build, mechanism: Mechanism, place: Values, rate: Values) -> tuple[Values, Values]:
    """Change of coordinates and of rates over a part.

    Dry friction is the mean of a part: no step sees where within it a rate ends.
    """
    dt, before, known = build.part, build.prefix, mechanism.known(place, rate)
    friction, further = mechanism.friction(known, rate)
    rates, changes = [rate], [mechanism.accelerations(known, friction)]
    for stage, part in enumerate(STAGES, 2):
        build.prefix = f"{before}stage{stage}_"
        there = build.each("place", place + part * dt * rates[-1])
        rates.append(build.each("rate", rate + part * dt * changes[-1]))
        changes.append(mechanism.accelerations(mechanism.known(there, rates[-1]), friction))
    return _mean(rates) * dt + further, _mean(changes) * dt


def _mean(values: Sequence[Values]) -> Values:
    first, second, third, last = values
    return (first + 2 * (second + third) + last) / 6


def mean_friction(
    build: Build, most: Sequence[Expr], rates: Values, free: Values, by_forces: Values
) -> tuple[Values, Values]:
    """Mean dry friction along several ways over a part ``# (n,)``, and what its early part moves more (force s²).

    Args:
        build: takes intermediate results.
        most: friction at most, along each way.
        rates: along the ways ``# (n,)``.
        free: mean accelerations along them without friction ``# (n,)``.
        by_forces: mean accelerations along them per force along each ``# (n, n)``.
    """
    friction, early = (np.zeros(len(most), dtype=int).astype(object) for _ in range(2))
    for sweep in range(SWEEPS if len(most) > 1 else 1):
        for way, limit in enumerate(most):
            inertia = build.short(f"moved_{way}", 1 / by_forces[way, way])
            others = np.delete(by_forces[way] * friction, way).sum()
            other = build.short(f"pull{sweep}_{way}", inertia * (free[way] + others))
            mean, more = dry_friction(limit, rates[way], build.part, inertia, other)
            friction[way] = build.name(f"dry{sweep}_{way}", mean)
            early[way] = build.name(f"early_{way}", more)  # of the last sweep
    return friction, early
