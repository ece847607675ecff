"""Equations before and after, with the terms that the findings bring marked."""

from collections.abc import Collection, Mapping, Sequence

from markupsafe import Markup
from sympy import Add, Expr, Symbol
from sympy.printing.mathml import MathMLPresentationPrinter

from sym2real.diagnosis import Finding
from sym2real.effects import Effect, compose, effect
from sym2real.effects.body import Body
from sym2real.effects.frames import axes
from sym2real.effects.terms import ACTING, shielded
from sym2real.report.html.page import Formula, Formulas
from sym2real.report.tables import rounded
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
    names = _attitude(before) | _names(after, effects)
    changed = {name: value for name, value in after.quantities.items() if before.quantities.get(name) != value}

    def shown(expression: Expr, marked: Collection[Symbol] = ()) -> Markup:
        return mathml(expression.xreplace(names), [entry.xreplace(names) for entry in marked])

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
        there = [entry for entry in marked if entry.name in names_in(now)]
        every.append(both(f"{column} after a step", before.next.get(column), now, there))
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
        entry: Symbol(f"R_{row}{column}")
        for column, axis in enumerate(axes(body), start=1)
        for row, entry in enumerate(axis, start=1)
    }


def _shown(name: str) -> str:
    return f"{name.removeprefix(ACTING)} that acts" if name.startswith(ACTING) else name


def _symbols(of: Effect, finding: Finding) -> dict[str, Expr | float]:
    """A symbol for every parameter of a finding that a fit can vary, the value of the others."""
    fitted = {parameter.name for parameter in of.parameters if parameter.fitted}
    return {name: of.symbols()[name] if name in fitted else value for name, value in finding.values.items()}


def _names(equations: Equations, effects: Mapping[str, Effect]) -> dict[Expr, Expr]:
    """Symbols as people read them, what follows a _ below: parameters with their effect, what acts in place of what."""
    acting = [name for name in equations.quantities if name.startswith(ACTING)]
    names: dict[Expr, Expr] = {symbol(name): Symbol(f"{name.removeprefix(ACTING)}_acting") for name in acting}
    for key, chosen in effects.items():
        names |= {own: Symbol(key if name == "value" else f"{name}_{key}") for name, own in chosen.symbols().items()}
    return names


def mathml(expression: Expr, marked: Collection[Expr] = ()) -> Markup:
    """An expression with its numbers to four digits, a sum in terms between which a line may end.

    Terms with one of the marked symbols get the class "new".
    """
    short, printer, shown = rounded(expression), MathMLPresentationPrinter({"mul_symbol": "dot"}), []
    for place, term in enumerate(short.as_ordered_terms() if isinstance(short, Add) else [short]):
        negative = term.could_extract_minus_sign()
        sign = "−" if negative else "+" if place else ""
        operator = f"<mo form='infix'>{sign}</mo>" if sign else ""
        attribute = ' class="new"' if term.free_symbols & {*marked} else ""
        body = printer.doprint(-term if negative else term)
        shown.append(Markup(f"<math{attribute}><mrow>{operator}{body}</mrow></math>"))
    return Markup(" ").join(shown)
