"""Ways in which effects alter equations: another quantity, input, hidden state, or measurement."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache

from sympy import Expr, Integer, Symbol

from sym2real.effects.body import GRAVITY, Body
from sym2real.field import Field
from sym2real.layout import Layout
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import canonical, exchange, names_in
from sym2real.vocabulary import MOTOR_TORQUES

LAGGED = "rotor_thrust"
# Before the name of an action or a force, of the quantity that stands in its place in equations with many effects.
ACTING = "acting_"


def acting(equations: Equations, name: str) -> Symbol:
    """The symbol of an action or a force, or of the quantity that stands in its place."""
    return symbol(ACTING + name if ACTING + name in equations.quantities else name)


@lru_cache(maxsize=8)
def shielded(base: Equations) -> Equations:
    """The equations with a quantity in place of every action and wrench input: substitutions then stay small."""
    names = [name for name in (*base.layouts.action, *base.layouts.inputs.pushes) if name not in base.quantities]
    aliases = {name: symbol(ACTING + name) for name in names}
    blank = replace(base, quantities={**base.quantities, **{alias.name: Integer(0) for alias in aliases.values()}})
    changed = blank.substitute(aliases)
    own = {alias.name: symbol(name) for name, alias in aliases.items()}
    others = {name: value for name, value in changed.quantities.items() if name not in own}
    return replace(changed, quantities={**own, **others})


def acting_thrust(equations: Equations) -> Symbol:
    """The symbol of the thrust that really acts on the body, N: behind motor lag where there is some."""
    return symbol(LAGGED if LAGGED in equations.quantities else "thrust")


def acting_torque(equations: Equations, axis: str) -> Expr:
    """Torque of motors about an axis, N m, behind motor lag where there is some; zero of other equations."""
    name = f"torque_{axis}"
    lagged = lagging(name)
    if lagged in equations.quantities:
        return symbol(lagged)
    return symbol(name) if name in equations.quantities else Integer(0)


def lagging(name: str) -> str:
    """Of what motor lag makes of a torque of motors."""
    return f"rotor_{name}"


def hover_thrust(body: Body) -> float:
    """Thrust that carries the nominal robot, N."""
    return body.mass * GRAVITY


def scaled(equations: Equations, factor: Expr) -> Equations:
    """The equations with thrust times a factor.

    Where the thrust is that of motors, their torques scale alike: it is the rotors that give more or less.
    """
    names = ["thrust"]
    if "thrust" in equations.quantities:
        names += [name for name in MOTOR_TORQUES if name in equations.quantities]
    return equations.substitute({name: symbol(name) * factor for name in names})


def defined(equations: Equations, quantities: dict[str, Expr]) -> Equations:
    """The equations with quantities defined anew or added."""
    return replace(equations, quantities={**equations.quantities, **quantities})


def raised(equations: Equations, quantity: str, value: Expr) -> Equations:
    """The equations with more of a quantity, wherever they use it."""
    return defined(equations, {quantity: canonical(equations.quantities[quantity] + value)})


def multiplied(equations: Equations, quantities: Iterable[str], factor: Expr) -> Equations:
    """The equations with so many times some of their quantities, wherever they use them."""
    return defined(equations, {name: canonical(equations.quantities[name] * factor) for name in quantities})


def without_quantities(equations: Equations, expression: Expr, names: Collection[str] | None = None) -> Expr:
    """An expression over columns and parameters; with names, only quantities of these names are put in."""
    quantities = equations.quantities if names is None else {name: equations.quantities[name] for name in names}
    put_in = exchange({symbol(name): value for name, value in quantities.items()})
    while names_in(expression) & quantities.keys():
        expression = put_in(expression)
    return expression


def with_hidden(equations: Equations, name: str, unit: str, following: Expr, start: Expr) -> Equations:
    """The equations with one more state, last and hidden: what follows it, and its first value."""
    field = Field(name.replace("_", " "), (name,), unit, "body", hidden=True)
    return replace(
        equations,
        layouts=replace(equations.layouts, state=equations.layouts.state + Layout((field,))),
        next={**equations.next, name: following},
        start={**equations.start, name: start},
    )


def begun_at_rest(equations: Equations, changes: Mapping[str, Expr]) -> Equations:
    """Substituted but in what hidden states begin with: what has been held for ever is its own mean."""
    return replace(equations.substitute(changes), start=equations.start)


def with_time(equations: Equations) -> tuple[Equations, Expr]:
    """The equations with the input ``t`` (s since the recording began), last where they had none; mid-step time."""
    return replace(equations, layouts=equations.layouts.with_input("t")), symbol("t") + equations.dt / 2


def reported(equations: Equations, column: str) -> Expr:
    """What is measured of a state column."""
    return equations.output.get(column, symbol(column))


def reporting(equations: Equations, outputs: Mapping[str, Expr]) -> Equations:
    """The equations with other outputs; the motion is the same."""
    return replace(equations, output={**equations.output, **outputs})
