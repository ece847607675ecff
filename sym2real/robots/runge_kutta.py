"""One control period of equations of motion by the classical Runge–Kutta method, in as many parts as the robot needs.

A servo of the rate may brake within a fraction of a period; a step that is long beside that swings up.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np
from sympy import Expr, Rational, count_ops

from sym2real.robots.spatial import Values
from sym2real.symbolic import symbol
from sym2real.trajectory import Array

# Decay in a part of a period; Runge–Kutta steps swing up beyond 2.8, and a joint may brake twice as much as described.
DECAY = 1.4
# What is left of the 2.8 where dry friction holds: that decays twice in a part, whatever its length.
DECAY_BESIDE_DRY = 0.8
STAGES = (Rational(1, 2), Rational(1, 2), 1)  # parts of the period behind which the rates are asked again
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


def parts_of(decay: float, dt: float, *, dry: bool = False) -> int:
    """Runge–Kutta steps in a period, by how fast rates decay (1/s), and whether dry friction brakes them as well."""
    return max(1, math.ceil(decay * dt / (DECAY_BESIDE_DRY if dry else DECAY)))


def stepped(
    build: Build, accelerations: Callable[[Values, Values], Values], place: Values, rate: Values
) -> tuple[Values, Values]:
    """Change of coordinates over a period, and the rates behind it."""
    moved, start = 0, place
    for part in range(build.parts):
        _show.get()(f"deriving the equations of {len(place)} joints: step {part + 1} of {build.parts} in a period")
        build.prefix = f"part{part + 1}_" if part else ""
        if part:
            place, rate = build.each("place", start + moved), build.each("rate", rate)
        further, gained = _step(build, accelerations, place, rate)
        moved, rate = moved + further, rate + gained
    return moved, rate


def _step(
    build: Build, accelerations: Callable[[Values, Values], Values], place: Values, rate: Values
) -> tuple[Values, Values]:
    """Change of coordinates and of rates over a part."""
    dt, before, rates, changes = build.part, build.prefix, [rate], [accelerations(place, rate)]
    for stage, part in enumerate(STAGES, 2):
        build.prefix = f"{before}stage{stage}_"
        there = build.each("place", place + part * dt * rates[-1])
        rates.append(build.each("rate", rate + part * dt * changes[-1]))
        changes.append(accelerations(there, rates[-1]))
    return _mean(rates) * dt, _mean(changes) * dt


def _mean(values: Sequence[Values]) -> Values:
    first, second, third, last = values
    return (first + 2 * (second + third) + last) / 6
