"""An expression of a user's own as a term of an input or a command."""

from dataclasses import replace

from sympy import Expr

from sym2real.effects.body import Body
from sym2real.effects.frames import body_velocity
from sym2real.effects.inputs import TIME
from sym2real.effects.known_effects import TERM
from sym2real.effects.terms import with_time
from sym2real.effects.wrench import with_force_inputs
from sym2real.errors import ModelError, UnknownNameError
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.parsing import parse_expression
from sym2real.vocabulary import FORCE, HEIGHT, VELOCITY


def add_term(equations: Equations, channel: str, expression: str) -> Equations:
    """The equations with an expression added to an input or command, wherever it stands; to a force, where they can.

    Raises:
        UnknownNameError: for a channel or a name that the equations do not have.
        ModelError: for text that is not an expression.
    """
    equations = with_force_inputs(equations) if channel in FORCE.columns else equations
    known = (*equations.layouts.inputs, *equations.layouts.action)
    if channel not in known:
        raise UnknownNameError("input or command of the model", channel, known)
    try:
        parsed = parse_expression(expression)
    except ModelError as error:
        raise ModelError(f"term of {channel}: {error}") from error
    if any(symbol.name == TIME for symbol in parsed.free_symbols):
        equations, _ = with_time(equations)
    changed = equations.substitute({channel: symbol(channel) + parsed})
    note = f"unverified: the term {expression} in {channel}"
    return replace(changed, notes=(*changed.notes, note), effects=(*changed.effects, (f"{TERM}{channel}", {})))


def nameable(equations: Equations) -> dict[str, Expr]:
    """What a term may depend on, by the names that people use, as expressions over the equations' columns."""
    layouts, body = equations.layouts, Body.of(equations)
    names = {*layouts.state, *layouts.action, *layouts.inputs}
    terms: dict[str, Expr] = {name: symbol(name) for name in sorted(names)}
    terms |= {"time": symbol(TIME)} | ({"height": symbol(HEIGHT)} if HEIGHT in names else {})
    along = [name for name in VELOCITY.columns if name in names]
    if along:
        terms |= {f"velocity {axis}": symbol(name) for axis, name in zip("xyz", along, strict=False)}
        if layouts.state.has_field("attitude"):
            terms |= {f"body velocity {axis}": value for axis, value in zip("xyz", body_velocity(body), strict=True)}
        elif layouts.state.has_field("heading"):
            terms["forward speed"] = body_velocity(body)[0]
    return terms
