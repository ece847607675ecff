"""Equations before and after, with what the findings bring marked."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from markupsafe import Markup
from sympy import Expr, Symbol

from sym2real.effects.thrust import ACTING
from sym2real.report.html.mathml import mathml
from sym2real.report.html.page import Formula, Formulas
from sym2real.report.html.variants import WithFindings
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in

LONG = 1500  # characters of MathML: what is longer is folded away
READING = (
    "What acts on the robot in place of what is commanded or known. Marked: what the findings bring; their values "
    "stand with each effect."
)


def formulas(variants: WithFindings) -> list[Formulas]:
    """What findings change, and all equations before and after."""
    after, before = variants.equations, variants.shielded
    new = {symbol(name) for name in after.parameters if name not in before.parameters}
    names = _names(variants)
    changed = {name: value for name, value in after.quantities.items() if before.quantities.get(name) != value}
    put_in = [Formula(_shown(name), Markup(), mathml(value, new, names)) for name, value in changed.items()]
    put_in += [Formula(f"measured {name}", Markup(), mathml(value, new, names)) for name, value in after.output.items()]
    put_in += [_filter(key, values, new, names) for key, values in after.filters]
    short = [one for one in put_in if len(one.after) <= LONG]
    marked = new | {symbol(name) for name in changed}
    every = [one for one in put_in if len(one.after) > LONG]
    every += [_both(column, before, after, marked, names) for column in after.next]
    return [
        *([Formulas("What is put into the equations", short, READING)] if short else []),
        Formulas("All equations, before and after", every, "Marked: terms that are no longer the same.", folded=True),
    ]


def _shown(name: str) -> str:
    return f"{name.removeprefix(ACTING)} that acts" if name.startswith(ACTING) else name


def _names(variants: WithFindings) -> dict[str, str]:
    """What symbols are called: parameters after their effect, what acts after what was commanded."""
    names = {
        name: f"{name.removeprefix(ACTING)}|acting" for name in variants.equations.quantities if name.startswith(ACTING)
    }
    for key, effect in variants.effects.items():
        for name, one in effect.symbols().items():
            names[one.name] = key if name == "value" else f"{key}|{name}"
    return names


def _filter(key: str, values: Mapping[str, Expr], new: Collection[Symbol], names: dict[str, str]) -> Formula:
    shown = Markup(", ").join(mathml(value, new, names) for value in values.values())
    return Formula(f"commands through {key}", Markup(), shown)


def _both(
    column: str, before: Equations, after: Equations, marked: Collection[Symbol], names: dict[str, str]
) -> Formula:
    was = mathml(before.next[column], (), names) if column in before.next else Markup("–")
    now = after.next[column]
    shown = [one for one in marked if one.name in names_in(now)]
    return Formula(f"{column} after a step", was, mathml(now, shown, names))
