"""Forces along joints into equations: through their inputs, or approximately where they have none."""

from collections.abc import Iterable
from dataclasses import replace

from sympy import Expr

from sym2real.effects.body import Body
from sym2real.effects.wrench import uses
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import canonical
from sym2real.vocabulary import push_column, rate_column

INERTIA = "{column}_inertia"  # the number of a joint that its effects need
ALONE = "{column}_alone"  # what a force along it moves while no other joint is held: the least


def inertia(body: Body) -> float:
    """What a force along the bound joint moves, kg or kg m²; 1 where nobody knows."""
    return body.numbers.get(INERTIA.format(column=body.column), 1.0)


def unit_of_push(body: Body) -> tuple[str, str]:
    """Unit of a force along the bound joint, and of its rate."""
    return ("N m", "rad/s") if body.unit == "rad" else ("N", "m/s")


def raised(equations: Equations, quantity: str, value: Expr) -> Equations:
    """The equations with more of a quantity, wherever they use it."""
    more = canonical(equations.quantities[quantity] + value)
    return replace(equations, quantities={**equations.quantities, quantity: more})


def multiplied(equations: Equations, quantities: Iterable[str], factor: Expr) -> Equations:
    """The equations with so many times some of their quantities, wherever they use them."""
    changed = {name: canonical(equations.quantities[name] * factor) for name in quantities}
    return replace(equations, quantities={**equations.quantities, **changed})


def braked(equations: Equations, body: Body, quantity: str, value: Expr, force: Expr) -> Equations:
    """The equations with more of what brakes the bound joint, or with its force along the joint where they lack it."""
    if quantity in equations.quantities:
        return raised(equations, quantity, value)
    return push_along(equations, body, force)


def push_along(equations: Equations, body: Body, force: Expr) -> Equations:
    """The equations with a force in N, or a torque in N m, along the bound joint.

    An input that the equations use takes it exactly. Else rate and coordinate take ``dt F/I`` and ``½ dt² F/I``, which
    the notes call approximate: what is coupled to the joint is not pushed.
    """
    joint, name = body.column, push_column(body.column)
    if name in equations.layouts.inputs and uses(equations, name):
        return equations.substitute({name: symbol(name) + force})
    change = equations.dt * force / body.number(INERTIA.format(column=joint))
    rate = rate_column(joint)
    moved = {rate: equations.next[rate] + change, joint: equations.next[joint] + equations.dt / 2 * change}
    note = f"approximate: the equations have no input {name}"
    return replace(equations, next={**equations.next, **moved}, notes=tuple(dict.fromkeys((*equations.notes, note))))
