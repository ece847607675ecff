"""Equations for people: on one line, as text, as LaTeX."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy

from sym2real.symbolic.expressions import symbol, text

if TYPE_CHECKING:
    from sym2real.symbolic.equations import Equations


def summary(equations: Equations) -> str:
    """Whose they are, the columns that they predict, the time step in s, the effects in them."""
    of = f" of {equations.robot}" if equations.robot else ""
    effects = f", with {', '.join(key for key, _ in equations.effects)}" if equations.effects else ""
    return f"<Equations{of}: {' '.join(equations.next)} after {equations.dt:g} s{effects}>"


def as_text(equations: Equations) -> str:
    """See :meth:`Equations.text`."""
    lines = [f"{name} = {text(expression)}" for name, expression in equations.quantities.items()]
    lines += [f"{column}' = {text(expression)}" for column, expression in equations.next.items()]
    lines += [f"measured {column} = {text(expression)}" for column, expression in equations.output.items()]
    lines += [f"{column} at the start = {text(expression)}" for column, expression in equations.start.items()]
    for key, values in equations.filters:
        lines.append(f"{key}: {', '.join(f'{name} = {text(value)}' for name, value in values.items())}")
    lines += [f"{name} = {value!r}" for name, value in equations.parameters.items()]
    return "\n".join(lines)


def as_latex(equations: Equations) -> dict[str, str]:
    """See :meth:`Equations.latex`."""
    measured = {f"measured {column}": expression for column, expression in equations.output.items()}
    parts = {**equations.quantities, **equations.next, **measured}
    return {name: sympy.latex(value) for name, value in parts.items()}


def latex_lines(equations: Equations) -> list[str]:
    """All of :func:`as_latex` behind their names, to be aligned at "="; the next value of a column has a prime."""
    primes, lines = dict.fromkeys(equations.next, "'"), []
    for name, formula in as_latex(equations).items():
        words, _, column = name.rpartition(" ")
        prefix = rf"\text{{{words} }}" if words else ""
        lines.append(f"{prefix}{sympy.latex(symbol(column))}{primes.get(name, '')} &= {formula}")
    return lines
