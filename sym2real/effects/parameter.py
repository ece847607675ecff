"""A named parameter of equations of one's own is another one than was given: p → k·p.

What stands in equations as a number is known; what has a name there may be wrong.
"""

from dataclasses import replace

from sym2real.effects.body import GRAVITY, Body
from sym2real.effects.kind import Kind, Numbers, Parameter, Values, of_any_body
from sym2real.effects.searching import Searching
from sym2real.errors import ModelError
from sym2real.protocols import Change
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in

LEAST, MOST = 0.1, 10.0  # what is likely
ON_EARTH = 0.03  # m/s²: gravity differs by as much from pole to equator
STEP = 1e-6  # part of a control period by which a rounded one may be off


def _known(body: Body) -> str:
    """Why nobody need ask for the parameter; "" for one that may be wrong."""
    value = body.parameters.get(body.column, 1.0)
    if value == 0.0:
        return "is zero, and so is every multiple of it"
    if abs(value - body.dt) <= STEP * body.dt:
        return "is the time step, which is known"
    if body.column.startswith("g") and abs(abs(value) - GRAVITY) <= ON_EARTH:
        return "is gravity, which is known"
    return ""


def _substitute(equations: Equations, values: Values, body: Body) -> Equations:
    name, factor = body.column, values["factor"]
    parts = (equations.next, equations.quantities, equations.output, equations.start)
    if not any(name in names_in(expression) for part in parts for expression in part.values()):
        raise ModelError(f"no equation has {name}")
    if factor.is_number:
        return replace(equations, parameters={**equations.parameters, name: float(factor) * equations.parameters[name]})
    return equations.substitute({name: factor * symbol(name)})


def _inject(body: Body, values: Numbers) -> Change:
    raise ModelError(f"no simulator has the equations' parameter {body.column!r}")


PARAMETER = Kind(
    name="parameter",
    stage="mass",
    parameters=of_any_body(Parameter("factor", "1", null=1.0, low=LEAST, high=MOST, scale=0.1)),
    formula=r"p \to k\,p",
    summary="A parameter of the equations is so many times what was given.",
    confused_with="every other parameter and effect that enters the equations beside it: a mass and every force",
    shown_by="motion in which each of the equations' terms is large for a while, and the others are not",
    fix="measure it; if it is as given, look for what else scales its terms",
    inject=_inject,
    substitute=_substitute,
    robot="model with named parameters",
    columns="parameter",
    searching=Searching(why_not=_known),
)
