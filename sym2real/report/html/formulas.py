"""Equations before and after, with what the findings bring marked."""

from collections.abc import Collection, Mapping, Sequence

from markupsafe import Markup
from sympy import Expr, Symbol

from sym2real.diagnosis import Finding
from sym2real.diagnosis.predict.library import shielded
from sym2real.effects import Effect, compose, effect
from sym2real.effects.body import Body
from sym2real.effects.frames import axes
from sym2real.effects.terms import ACTING
from sym2real.report.html.mathml import mathml
from sym2real.report.html.page import Formula, Formulas
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in

LONG = 6000  # characters of MathML: what is longer is folded away
READING = (
    "What acts on the robot in place of what is commanded or known. Marked: what the findings bring; their values "
    "stand with each effect."
)


def formulas(base: Equations, findings: Sequence[Finding]) -> list[Formulas]:
    """What findings change in a base, and all equations before and after."""
    for finding in findings:
        base = finding.bound(base)
    effects = {finding.effect: effect(finding.effect, base) for finding in findings}
    # What an effect may change gets a name of its own before it acts; what a fit has varied stays a symbol.
    before = shielded(base)
    after = compose(
        before, [(effects[finding.effect], _symbols(effects[finding.effect], finding)) for finding in findings]
    )
    new = {symbol(name) for name in after.parameters if name not in before.parameters}
    names, attitude = _names(after, effects), _attitude(before)
    changed = {name: value for name, value in after.quantities.items() if before.quantities.get(name) != value}

    def shown(expression: Expr, marked: Collection[Symbol] = ()) -> Markup:
        return mathml(expression.xreplace(attitude), marked, names)

    def both(name: str, was: Expr | None, now: Expr, marked: Collection[Symbol]) -> Formula:
        return Formula(name, Markup() if was is None else shown(was), shown(now, marked))

    put_in = [both(_shown(name), before.quantities.get(name), value, new) for name, value in changed.items()]
    put_in += [both(f"measured {name}", symbol(name), value, new) for name, value in after.output.items()]
    put_in += [
        Formula(f"commands through {key}", Markup(), Markup(", ").join(shown(value, new) for value in values.values()))
        for key, values in after.filters
    ]
    marked = new | {symbol(name) for name in changed}
    every = [formula for formula in put_in if len(formula.after) > LONG]
    for column, now in after.next.items():
        every.append(both(f"{column} after a step", before.next.get(column), now, _in(now, marked)))
    short = [formula for formula in put_in if len(formula.after) <= LONG]
    return [
        *([Formulas("What is put into the equations", short, _reading(READING, short))] if short else []),
        Formulas("All equations, before and after", every, _reading("Marked: terms that changed.", every), folded=True),
    ]


def _reading(about: str, formulas: Sequence[Formula]) -> str:
    turned = any("<mi>R</mi>" in formula.after for formula in formulas)
    return f"{about} R turns vectors from body axes to world axes." if turned else about


def _attitude(equations: Equations) -> dict[Expr, Expr]:
    """Entries of the rotation matrix by their expression in the quaternion; none in a plane."""
    body = Body.of(equations)
    if "qw" not in body.names:
        return {}
    return {
        entry: Symbol(f"R|{row}{column}")
        for column, axis in enumerate(axes(body), start=1)
        for row, entry in enumerate(axis, start=1)
    }


def _in(expression: Expr, marked: Collection[Symbol]) -> list[Symbol]:
    return [entry for entry in marked if entry.name in names_in(expression)]


def _shown(name: str) -> str:
    return f"{name.removeprefix(ACTING)} that acts" if name.startswith(ACTING) else name


def _symbols(of: Effect, finding: Finding) -> dict[str, Expr | float]:
    """A symbol for every parameter of a finding that a fit can vary, the value of the others."""
    fitted = {parameter.name for parameter in of.parameters if parameter.fitted}
    return {name: of.symbols()[name] if name in fitted else value for name, value in finding.values.items()}


def _names(equations: Equations, effects: Mapping[str, Effect]) -> dict[str, str]:
    """What symbols are called: parameters after their effect, what acts after what was commanded."""
    names = {name: f"{name.removeprefix(ACTING)}|acting" for name in equations.quantities if name.startswith(ACTING)}
    for key, chosen in effects.items():
        for name, parameter in chosen.symbols().items():
            names[parameter.name] = key if name == "value" else f"{key}|{name}"
    return names
