"""Forces and torques into equations, along joints too: through their inputs, or approximately where they have none.

What acts across the motion of a car whose tyres hold works on the turn, not the tyres. The car has one degree of
freedom, along its heading; the heading turns by tan(δ)/L per metre, so by virtual work a yaw torque τ_z acts along
the heading with τ_z tan(δ)/L, and a force F across it at a distance c ahead of the rear axle with c F tan(δ)/L.
"""

from collections.abc import Sequence
from dataclasses import replace

from sympy import Expr, Rational, tan

from sym2real.effects.body import Body
from sym2real.effects.frames import axes, body_velocity, dot
from sym2real.effects.kind import Substitute
from sym2real.effects.terms import multiplied, raised
from sym2real.errors import ModelError
from sym2real.layout import Layout
from sym2real.symbolic import Equations, symbol
from sym2real.symbolic.expressions import names_in
from sym2real.vocabulary import FORCE, STEER_COLUMN, MechanicalQuantity, push_column, quantity_of, rate_column

AXES = ("x", "y", "z")


def apply_wrench(
    equations: Equations, body: Body, force: Sequence[Expr] = (), torque: Sequence[Expr] = ()
) -> Equations:
    """The equations with a force in N along world axes and a torque in N m about body axes.

    A wrench input that the equations use takes it exactly. Else velocity and position take ``dt F/m`` and
    ``½ dt² F/m``, of a robot on wheels along its heading alone and as far as its speed loop lets them, and a rate
    command takes ``τ/(J K)``: approximate, which the notes say.

    Raises:
        ModelError: when the equations have no place for a component that is not zero.
    """
    exact = {axis for axis in AXES if uses(equations, f"f{axis}")}
    if force and body.on_wheels and not exact:
        force = _along_the_heading(body, force, (1.0 + _kept(equations)) / 2.0)
    changes: dict[str, Expr] = {}
    for axis, value in zip(AXES, force, strict=False):
        if not value.is_zero:
            name = f"f{axis}"
            if axis in exact:
                changes[name] = symbol(name) + value
            else:
                equations = _approximate(_accelerated(equations, body, axis, value), name)
    for axis, value in zip(AXES, torque, strict=False):
        if not value.is_zero:
            equations, change = _torque(equations, body, axis, value)
            changes |= change
    return equations.substitute(changes)


def with_force_inputs(equations: Equations) -> Equations:
    """The equations with inputs ``fx fy fz`` of a force in N, zero where none acts, as :func:`apply_wrench` adds one.

    As they are where they have one, where their mass is unknown, or where a force has no place.
    """
    body = Body.of(equations)
    names = [column for column in FORCE.columns[: 2 if body.planar else 3] if f"v{column[1]}" in equations.next]
    if len(names) < 2 or "mass" not in equations.numbers or any(uses(equations, name) for name in names):
        return equations
    missing = Layout.of(name for name in names if name not in equations.layouts.inputs)
    layouts = replace(equations.layouts, inputs=equations.layouts.inputs + missing)
    return apply_wrench(replace(equations, layouts=layouts), body, force=[symbol(name) for name in names])


def uses(equations: Equations, name: str) -> bool:
    """Whether any equation of motion depends on a name."""
    return name in equations.names and any(equations.depends(column, name) for column in equations.next)


def _kept(equations: Equations) -> float:
    """Part of a speed that a speed loop leaves after a step, straight ahead; one where none is in the equations.

    What a force gives in a step is so much less at its end, on average by half of what the loop takes.
    """
    speed, ahead = symbol("vx"), equations.next["vx"]
    while derived := names_in(ahead) & equations.quantities.keys():
        ahead = ahead.subs({symbol(name): equations.quantities[name] for name in derived})
    rest = {symbol(name): 0.0 for name in equations.names} | {symbol("cos_yaw"): 1.0}
    kept = float(ahead.diff(speed).subs(rest))
    return kept if 0.0 < kept < 1.0 else 1.0


def _along_the_heading(body: Body, force: Sequence[Expr], share: float) -> list[Expr]:
    """What of a force moves a robot whose tyres hold: its work along the heading, and on the turn, per metre."""
    forward, left = axes(body)
    force = force[: len(forward)]
    ahead = dot(forward, force)
    if STEER_COLUMN in body.layouts.action and "wheelbase" in body.numbers:
        lever = body.numbers.get("centre", 0.0) / body.number("wheelbase")
        ahead += lever * tan(symbol(STEER_COLUMN)) * dot(left, force)
    return [share * ahead * component for component in forward]


def _accelerated(equations: Equations, body: Body, axis: str, value: Expr) -> Equations:
    velocity = f"v{axis}"
    if velocity not in equations.next:
        raise ModelError(f"the equations have neither the input f{axis} nor the state {velocity}: a force has no place")
    change = equations.dt * value / _number(equations, body, "mass")
    steps = {velocity: change, axis: Rational(1, 2) * equations.dt * change}
    moved = {column: equations.next[column] + step for column, step in steps.items() if column in equations.next}
    return replace(equations, next={**equations.next, **moved})


def _torque(equations: Equations, body: Body, axis: str, value: Expr) -> tuple[Equations, dict[str, Expr]]:
    name, rate, command = f"t{axis}", f"w{axis}", f"w{axis}_cmd"
    if uses(equations, name):
        return equations, {name: symbol(name) + value}
    if uses(equations, command):
        gain = _number(equations, body, f"j{axis}") * body.number(f"k{axis}")
        return _approximate(equations, name), {command: symbol(command) + value / gain}
    if rate not in equations.next:
        raise ModelError(f"the equations have neither {name} nor {command} nor {rate}: a torque has no place")
    moved = {rate: equations.next[rate] + equations.dt * value / _number(equations, body, f"j{axis}")}
    return _approximate(replace(equations, next={**equations.next, **moved}), name), {}


def _number(equations: Equations, body: Body, name: str) -> Expr | float:
    """A number of the robot; of equations with a parameter of that name the parameter, so that another value counts."""
    return symbol(name) if name in equations.parameters else body.number(name)


def _approximate(equations: Equations, name: str) -> Equations:
    note = f"approximate: the equations have no wrench input {name}"
    return equations if note in equations.notes else replace(equations, notes=(*equations.notes, note))


INERTIA = "{column}_inertia"  # the number of a joint that its effects need
ALONE = "{column}_alone"  # what a force along it moves while no other joint is held: the least


def inertia(body: Body) -> float:
    """What a force along the bound joint moves, kg or kg m²; 1 where nobody knows."""
    return body.numbers.get(INERTIA.format(column=body.column), 1.0)


def strength(body: Body) -> float:
    """Largest force of the bound joint's actuators, N or N m; none where it has no actuator."""
    return body.numbers.get(f"{body.column}_strength", 0.0)


def force_unit(body: Body) -> str:
    """Of what acts along the bound joint: N m where it turns, N where it slides."""
    return "N m" if body.unit == "rad" else "N"


def altered(equations: Equations, body: Body, kind: MechanicalQuantity, value: Expr, force: Expr) -> Equations:
    """The equations with more of what the bound joint has, or with its force along the joint where they lack it."""
    if (quantity := quantity_of(kind, body.column)) in equations.quantities:
        return raised(equations, quantity, value)
    return apply_joint_force(equations, body, force)


def multiplying(kind: MechanicalQuantity) -> Substitute:
    """A substitute that makes so many times as much of what the bound joint has."""
    return lambda equations, values, body: multiplied(equations, [quantity_of(kind, body.column)], values["value"])


def apply_joint_force(equations: Equations, body: Body, force: Expr) -> Equations:
    """The equations with a force in N, or a torque in N m, along the bound joint.

    An input that the equations use takes it exactly. Else rate and coordinate take ``dt F/I`` and ``½ dt² F/I``, which
    the notes call approximate: what is coupled to the joint is not moved.
    """
    joint, name = body.column, push_column(body.column)
    if name in equations.layouts.inputs and uses(equations, name):
        return equations.substitute({name: symbol(name) + force})
    change = equations.dt * force / body.number(INERTIA.format(column=joint))
    rate = rate_column(joint)
    moved = {rate: equations.next[rate] + change, joint: equations.next[joint] + equations.dt / 2 * change}
    note = f"approximate: the equations have no input {name}"
    return replace(equations, next={**equations.next, **moved}, notes=tuple(dict.fromkeys((*equations.notes, note))))


FORWARD = ("vx", "vy", "sin_yaw", "cos_yaw")  # what the speed along the heading follows from


def forward_speed(body: Body) -> Expr:
    """u, m/s."""
    return body_velocity(body)[0]


def apply_force_ahead(equations: Equations, body: Body, force: Expr) -> Equations:
    """A force along the heading, N."""
    return apply_wrench(equations, body, force=[force * component for component in axes(body)[0]])


def apply_yaw_torque(equations: Equations, body: Body, torque: Expr) -> Equations:
    """A yaw torque in N m by the work it does."""
    return apply_force_ahead(equations, body, torque * tan(symbol("steer")) / body.number("wheelbase"))
